"""Laws of the cells that blind trials are made in."""

from dataclasses import replace

import numpy as np
import pytest

from robolaser.model.effects import EFFECTS
from robolaser.model.effects.effect import CandidateEffect
from robolaser.model.effects.joint_coupling import JointCoupling
from robolaser.model.effects.tracker_scale import TrackerScale
from robolaser.robot.by_name import find_robot
from robolaser.trials.building import Ranges
from robolaser.trials.detectability import Detectability
from robolaser.trials.resampling import build_tracked
from robolaser.trials.synthetic.fault_models import FAULT_MODELS, MODELLED, OUTLIERS, PHYSICAL, UNMODELLED
from robolaser.trials.synthetic.fault_models.joints import LedAlong, LostMotion, UncountedTurn
from robolaser.trials.synthetic.fault_models.loads import HystereticWindup
from robolaser.trials.synthetic.fault_models.surroundings import WrongRefractiveIndex
from robolaser.trials.synthetic.scanner import Light

SMALL = Ranges(poses=(12, 14), points=(6, 6))
LINEAR = ("encoder_scale", "joint_offset", "laser_roll")
"""Departures whose form is the library's own: what the library fits of them must be everything."""
NEARLY = ("arm_scale", "base_compliance", "focus_breathing", "hand_eye_sag", "link_compliance", "settling")
"""Departures whose form is nearly the library's."""


SAME = (
    "backlash", "base_shift", "encoder_scale", "joint_offset", "laser_drift", "laser_roll", "latency", "target_scale",
    "target_stretch", "thermal_drift", "transmission_error",
)  # fmt: skip
"""Departures of which some numbers mean the same in the library."""


FORMULAS = {name: model for name, model in FAULT_MODELS.items() if name not in PHYSICAL}
SEEN = {name: model for name, model in FORMULAS.items() if name != "tracker_scale"}
"""What a scanner sees."""


@pytest.fixture(params=SEEN.values(), ids=SEEN.keys())
def fault(request, built):
    fault_model, rng = request.param, np.random.default_rng(2)
    run = built.cell.run
    return fault_model.sample(fault_model.locations(run)[-1], np.sqrt(np.prod(fault_model.sizes)), run, rng)


def detectability(built, *faults):
    noise = built.noise
    return Detectability(built.exact(faults), built.cell.truth, {"pixel": noise.pixel_px, "target": noise.target_m})


def test_every_effect_that_a_scanner_sees_has_a_world_and_some_worlds_have_no_effect(built):
    assert not set(UNMODELLED) & {kind.name for kind in EFFECTS}
    assert not set(UNMODELLED) & set(MODELLED)
    assert {kind.name for kind in EFFECTS if kind.locations(built.blank)} <= {*MODELLED, OUTLIERS}


def test_two_chains_that_share_nothing_but_the_arm_agree_to_rounding(built):
    assert detectability(built).misfit < 1e-6


def test_the_arm_stands_where_the_package_says(built):
    run, robot = built.cell.run, built.blank.robot
    np.testing.assert_allclose(run.arm.forward(run.q), robot.forward(run.q[None])[0], atol=1e-12)
    np.testing.assert_allclose(run.torques(0.0), robot.gravity_torques(run.q), atol=1e-9)


def test_of_no_size_nothing_bends(fault, built):
    plain, bent = built.cell.seen(()), built.cell.seen((replace(fault, size=0.0),))
    np.testing.assert_allclose(bent.pixel, plain.pixel, rtol=0, atol=1e-7)
    np.testing.assert_allclose(bent.xyz, plain.xyz, rtol=0, atol=1e-10)


def test_of_usual_size_the_data_show_it(fault, built):
    rng = [np.random.default_rng(1) for _ in range(2)]
    plain, bent = built.read((), rng[0]), built.read((fault,), rng[1])
    assert len(plain.points) == len(bent.points)
    moved = np.abs(plain.points.pixel - bent.points.pixel).max() + np.abs(plain.points.xyz - bent.points.xyz).max()
    assert moved > 1e-5


def test_points_stay_in_their_columns_whatever_is_wrong(fault, built):
    if fault.effect in (OUTLIERS, "stripe_bias"):
        pytest.skip("it moves what is read, not what is seen")
    seen = built.cell.seen((fault,)).pixel
    shown = np.isfinite(seen[:, 0])
    np.testing.assert_allclose(seen[shown, 0], built.cell.at[shown], atol=1e-5)


@pytest.mark.parametrize("effect", NEARLY)
def test_the_library_explains_nearly_all_of_what_departs_in_a_form_of_its_own(effect, built):
    fault_model, run = FAULT_MODELS[effect], built.cell.run
    where = fault_model.locations(run)[0]
    judged = detectability(built, fault_model.sample(where, fault_model.sizes[1], run, np.random.default_rng(3)))
    kind = next(kind for kind in EFFECTS if kind.name == effect)
    assert judged.misfit > 100
    assert judged.left_by(CandidateEffect(kind, where)) < 0.05 * judged.misfit


@pytest.mark.parametrize("effect", LINEAR)
def test_the_library_explains_what_has_its_own_form(effect, built):
    fault_model, run = FAULT_MODELS[effect], built.cell.run
    where = fault_model.locations(run)[min(1, len(fault_model.locations(run)) - 1)]
    judged = detectability(built, fault_model.sample(where, fault_model.sizes[1], run, np.random.default_rng(3)))
    kind = next(kind for kind in EFFECTS if kind.name == effect)
    assert judged.misfit > 100
    assert judged.left_by(CandidateEffect(kind, where)) < 1.0


def test_play_rests_until_the_gap_is_crossed_and_trails_by_half_of_it(built):
    run, play = built.cell.run, LostMotion("joint_2", 0.02, 0.3)
    column = run.column("joint_2")
    there_and_back = np.concatenate([np.linspace(0, 0.5, 6), np.linspace(0.495, 0.0, 6)])
    q = np.tile(run.q[:1], (12, 1))
    q[:, column] = there_and_back
    lag = play.joints(q, replace(run, q=q, time=np.arange(12.0)))[:, column] - there_and_back
    np.testing.assert_allclose(lag[1:6], -0.01)
    assert lag[6] == pytest.approx(-0.005)
    np.testing.assert_allclose(lag[7:], 0.01)
    assert np.abs(lag).max() <= 0.01 + 1e-15


@pytest.mark.parametrize("effect", SAME)
def test_true_values_are_those_that_leave_nothing(effect, built):
    run, fault_model = built.cell.run, FAULT_MODELS[effect]
    size = np.sqrt(np.prod(fault_model.sizes))
    fault = fault_model.sample(
        fault_model.locations(run)[1 % len(fault_model.locations(run))], size, run, np.random.default_rng(3)
    )
    candidate = CandidateEffect({kind.name: kind for kind in EFFECTS}[effect], fault.where)
    known = fault.values(run)
    nearest = detectability(built, fault).nearest(candidate, known)
    assert {name: nearest[name] for name in known} == pytest.approx(known, rel=1e-3)


def test_a_form_that_is_nearly_the_librarys_has_nearly_its_numbers(built):
    run = built.cell.run
    coupled = LedAlong("joint_2", 2e-3, "joint_1", 0.3)
    nearest = detectability(built, coupled).nearest(CandidateEffect(JointCoupling, "joint_2"), coupled.values(run))
    assert nearest["ratio"] == pytest.approx(coupled.values(run)["ratio"], rel=0.1)


def test_a_cone_that_does_not_open_is_a_plane():
    rng = np.random.default_rng(5)
    flat = Light(0.14, np.full(20, 0.4), np.full(20, 0.1), np.zeros(20))
    point = rng.normal(size=(20, 3))
    plane = (point * flat.normals).sum(axis=1) - 0.14 * np.cos(0.4)
    np.testing.assert_allclose(flat.off(point), plane, atol=1e-12)


@pytest.fixture(scope="module")
def tracked():
    return build_tracked(find_robot("scorbot_er7"), SMALL, np.random.default_rng(4), moving=True)


def test_a_tracker_sees_the_arm_where_the_package_says(tracked):
    assert Detectability.of(tracked).misfit < 1e-6


def test_a_trackers_wrong_lengths_are_the_librarys(tracked):
    judged = Detectability.of(tracked, WrongRefractiveIndex("measuring_system", 1e-3))
    assert judged.misfit > 100
    assert judged.left_by(CandidateEffect(TrackerScale, "measuring_system")) < 1.0


@pytest.mark.parametrize("effect", [name for name, model in FORMULAS.items() if model.is_tracked()])
def test_what_a_tracker_sees_shows_in_its_points(effect, tracked):
    fault_model, run = FAULT_MODELS[effect], tracked.cell.run
    places = fault_model.locations(run)
    fault = fault_model.sample(places[-1], fault_model.sizes[1], run, np.random.default_rng(2))
    plain, bent = tracked.cell.seen(()), tracked.cell.seen((fault,))
    assert np.abs(plain.xyz - bent.xyz).max() > 1e-5


def test_hysteresis_comes_back_later_than_it_went(built):
    run, windup = built.cell.run, HystereticWindup("joint_2", 2e-3, 0.4)
    order, column = run.order, run.column("joint_2")
    torque = run.torques(run.payload_kg)[order, column]
    sunk = (windup.joints(run.q, run) - run.q)[order, column]
    spring = -2e-3 * torque / np.abs(torque).max()
    assert np.abs(sunk - spring).max() <= 2e-3 * 0.4 * np.ptp(torque) / np.abs(torque).max() / 2 + 1e-12
    assert np.abs(sunk - spring).max() > 1e-4


def test_a_dead_zone_is_behind_on_one_side_and_ahead_on_the_other(built):
    run, dead = built.cell.run, UncountedTurn("joint_2", 2e-3, 0.5, 0.2)
    off = (dead.joints(run.q, run) - run.q)[:, run.column("joint_2")]
    read_angle = run.q[:, run.column("joint_2")]
    assert off[read_angle.argmin()] == pytest.approx(-1e-3)
    assert off[read_angle.argmax()] == pytest.approx(1e-3)
