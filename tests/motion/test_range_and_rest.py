"""What is no limit of a joint's range, and what imitates a cause that is not in the library."""

from dataclasses import replace
from types import SimpleNamespace

import numpy as np
import pytest
from moved_arms import ROBOT
from plain_servos import LIFT, late_arm

from robolaser.motion.diagnosis import diagnose_motion
from robolaser.motion.effect import At, Trace
from robolaser.motion.effects.servo import TRACKING
from robolaser.motion.effects.transmission import TRANSMISSION
from robolaser.motion.gap import KindGap, at_flange
from robolaser.motion.kind_diagnosis import KindDiagnosis
from robolaser.motion.log import MotionLog
from robolaser.motion.quantities import quantities
from robolaser.motion.selection import SelectedEffect
from robolaser.motion.simulation import simulate_motion
from robolaser.robot.by_name import find_robot

LIMIT = next(one for one in TRACKING if one.name == "range_limit")


def trace(error: np.ndarray, top: float = np.inf) -> Trace:
    command = np.sin(np.linspace(0.0, 12.0, 600))[:, None]
    return Trace(command, np.minimum(command - error[:, None], top), *np.zeros((2, 600, 1)), np.full((600, 1), 0.02))


def test_a_joint_that_falls_short_everywhere_has_no_limit() -> None:
    short = 0.1 * np.sign(np.sin(np.linspace(0.0, 12.0, 600)))
    assert LIMIT.untested(trace(short)) == "no command exceeds the range that the joint reached"


def test_a_joint_that_stops_has_a_limit_on_that_side_only() -> None:
    stopped = trace(np.zeros(600), top=0.7)
    assert LIMIT.untested(stopped) == ""
    lower, upper = LIMIT.begins(LIMIT.numbers, stopped, 1.0, 0.0)
    assert np.isinf(lower)
    assert upper * LIMIT.numbers[1].usual == pytest.approx(0.7)


def test_a_limit_on_one_side_is_named() -> None:
    at = At(LIMIT, "elbow", 0)
    numbers = {"lower": (-np.inf, 0.0, "rad"), "upper": (0.7, 1e-4, "rad")}
    assert not SelectedEffect(at, 0.99, 0.0, None, (), numbers, np.ones(1)).is_on_bound


def test_a_joint_that_stands_while_it_is_sent_elsewhere_shows_no_effect() -> None:
    command = np.sin(np.linspace(0.0, 12.0, 600))[:, None]
    stuck = Trace(command, np.full((600, 1), 5.0), *np.zeros((2, 600, 1)), np.full((600, 1), 0.02))
    assert stuck.stuck
    assert np.isinf(stuck.error_within)
    assert not trace(np.zeros(600), top=0.7).stuck


def test_a_joint_whose_readings_have_the_wrong_sign_is_of_no_cause_at_its_place() -> None:
    log = late_arm(lag_s=0.03)
    found = diagnose_motion(replace(log, q=log.q * np.where(np.arange(len(log.joints)) == LIFT, -1.0, 1.0)), seed=0)
    assert (found.verdict, found.places[0].site, found.fit.findings) == ("unexplained", "lift", ())


def test_errors_of_joints_that_cancel_at_the_flange_are_none_there() -> None:
    error = np.random.default_rng(0).normal(size=50)
    cancelling, together = (np.stack([error, side * error], axis=1) for side in (-1.0, 1.0))
    robot = SimpleNamespace(jacobian=lambda q: np.full((1, 50, 6, 2), 0.4))
    log = SimpleNamespace(robot=robot, q=cancelling, command=np.zeros((50, 2)), run=np.arange(50) // 10)
    found, levers = at_flange(log, KindGap("tracking", "rad", *np.zeros((4, 2)), 50), cancelling, together, 1)
    assert (found["nominal"], found["calibrated"]) == pytest.approx((0.0, 0.0), abs=1e-9)
    low, high = found["after_ci95"]
    assert low < found["after"] < high
    assert levers == pytest.approx(400.0 * np.sqrt(3.0))


def test_a_gear_that_rests_has_its_lost_motion_where_the_last_motion_left_it() -> None:
    robot = ROBOT
    time = np.arange(600) / 100.0
    angle = np.interp(time, [1.0, 2.0, 3.5, 4.5], [0.0, 0.5, 0.5, 0.1])
    q = np.repeat(angle[:, None], len(robot.joints), axis=1) + np.random.default_rng(0).normal(0.0, 1e-5, (600, 4))
    none = np.full_like(q, np.nan)
    log = MotionLog("four", robot, ("a",), np.zeros(600, dtype=np.int64), time, none, q, none, none, q)
    of = quantities(log, "load")
    at = {when: of.approach[np.searchsorted(of.time_s, when)].round(1).tolist() for when in (0.6, 1.5, 2.7, 4.0, 5.2)}
    assert at == {0.6: [0.0] * 4, 1.5: [1.0] * 4, 2.7: [1.0] * 4, 4.0: [-1.0] * 4, 5.2: [-1.0] * 4}
    lost = next(one for one in TRANSMISSION if one.name == "lost_motion")
    assert lost.columns is not None
    assert np.array_equal(lost.columns(of, 1)[0][:, 1, 0], -of.approach[:, 1])


@pytest.mark.parametrize(("gained", "certain"), [(2.0, True), (0.5, False)])
def test_an_effect_that_explains_less_than_is_left_beside_it_is_not_certain(gained: float, certain: bool) -> None:
    rng = np.random.default_rng(0)
    run, before, after = np.repeat(np.arange(4), 100), rng.normal(size=(400, 1)), rng.normal(size=(400, 1))
    before, after = 10.0 * before / before.std(), after / after.std()
    gap = KindGap("tracking", "rad", np.array([10.0]), np.array([10.0]), np.array([1.0]), np.array([1e-3]), 400)
    at = At(next(one for one in TRACKING if one.name == "dead_zone"), "elbow", 0)
    finding = SelectedEffect(at, 0.99, 0.0, None, (), {"half_width": (0.02, 1e-4, "rad")}, np.array([gained]))
    (shown,) = KindDiagnosis(gap, (at,), (finding,), run, before, after, {}, np.zeros(1)).shown
    assert (shown.probability >= 0.9) is certain


@pytest.mark.parametrize(("left", "verdict"), [(0.35, "explained"), (0.6, "unexplained")])
def test_a_small_share_of_a_gap_is_explained_only_if_it_is_a_few_times_the_noise(left: float, verdict: str) -> None:
    rng = np.random.default_rng(0)
    run, before, after = np.repeat(np.arange(4), 100), rng.normal(size=(400, 1)), rng.normal(size=(400, 1))
    before, after = 10.0 * before / before.std(), left * after / after.std()
    gap = KindGap("torque", "Nm", np.array([10.0]), np.array([10.0]), np.array([left]), np.array([0.1]), 400)
    at = At(next(one for one in TRACKING if one.name == "dead_zone"), "elbow", 0)
    finding = SelectedEffect(at, 0.99, 0.0, None, (), {"half_width": (0.02, 1e-4, "rad")}, np.array([99.0]))
    assert KindDiagnosis(gap, (at,), (finding,), run, before, after, {}, np.zeros(1)).verdict == verdict


@pytest.mark.parametrize(("none", "verdict"), [(0.3, "explained"), (0.6, "unexplained")])
def test_a_gap_is_not_explained_by_what_is_less_likely_than_an_unknown_cause(none: float, verdict: str) -> None:
    rng = np.random.default_rng(0)
    run, before, after = np.repeat(np.arange(4), 100), rng.normal(size=(400, 1)), 0.1 * rng.normal(size=(400, 1))
    gap = KindGap("torque", "Nm", np.array([1.0]), np.array([1.0]), np.array([0.1]), np.array([0.1]), 400)
    at = At(next(one for one in TRACKING if one.name == "dead_zone"), "elbow", 0)
    finding = SelectedEffect(at, 0.4, none, None, (), {"half_width": (0.02, 1e-4, "rad")}, np.array([0.99]))
    assert KindDiagnosis(gap, (at,), (finding,), run, before, after, {}, np.zeros(1)).verdict == verdict


def test_a_joint_is_within_its_limit_also_where_it_begins() -> None:
    effects = {"range_limit:elbow_joint": -0.3, "lag:elbow_joint": 0.05}
    log = simulate_motion(find_robot("ur5e"), effects=effects, seed=15)
    elbow = log.joints.index("elbow_joint")
    assert log.command[[rows.start for rows in log.rows_of_runs], elbow].min() < -0.3
    assert log.q[:, elbow].min() == pytest.approx(-0.3, abs=1e-3)


def test_the_noise_is_no_larger_than_the_errors_of_the_named_effects() -> None:
    """Without what is in the model besides, unseen motions may be predicted better."""
    run, before, named = np.repeat(np.arange(4), 100), np.full((400, 1), 10.0), np.full((400, 1), 0.9)
    gap = KindGap("torque", "Nm", np.array([10.0]), np.array([10.0]), np.array([1.0]), np.array([1.0]), 400)
    part = KindDiagnosis(gap, (), (), run, before, np.ones((400, 1)), {}, np.zeros(1), named=named)
    assert part.as_named.gap.noise_floor == part.as_named.gap.after == pytest.approx(0.9)
