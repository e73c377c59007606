"""Effects of real cells, made by the library's own formulas and by the trials' other ones: both are named."""

from dataclasses import replace

import numpy as np
import pinocchio
import pytest
from worlds import kinds

from robolaser.data.stated_noise import Noise
from robolaser.diagnosis import examine
from robolaser.geometry.rigid_motion import from_angles
from robolaser.robot.by_name import find_robot
from robolaser.simulation import simulate
from robolaser.trials.building import Ranges, build
from robolaser.trials.synthetic.fault_models import FAULT_MODELS

ELASTIC = kinds("joint_compliance", "link_compliance", "base_compliance", "hand_eye_sag")
SCALES = kinds("arm_scale", "tracker_scale")
FOLLOWING = kinds("joint_coupling", "settling", "encoder_eccentricity", "encoder_scale", "joint_offset")
THEIRS = [
    ("base_compliance", "base", 1e-3),
    ("hand_eye_sag", "hand_eye", 1e-3),
    ("link_compliance", "panda_joint5", 1.5e-3),
    ("settling", "panda_joint4", 2e-3),
    ("joint_coupling", "panda_joint4", 2e-3),
]


def test_what_the_library_makes_it_names():
    made = simulate(find_robot("panda"), kind="point", poses=30, effects={"settling:panda_joint2": 1e-3}, seed=3)
    (found,) = examine(made.dataset, seed=0).findings
    assert str(found.candidate_effect) == "settling at panda_joint2"
    assert found.probability > 0.9


@pytest.mark.parametrize(("effect", "where", "size"), THEIRS)
def test_what_other_formulas_make_it_names_first(effect, where, size):
    rng = np.random.default_rng(5)
    built = build(find_robot("panda"), Ranges(poses=(30, 34)), rng, moving=False)
    fault = FAULT_MODELS[effect].sample(where, size, built.cell.run, rng)
    alike = ELASTIC + kinds("joint_offset") if effect in {one.name for one in ELASTIC} else FOLLOWING
    found = examine(built.read([fault], rng), alike + kinds("link_geometry"), seed=0).findings[0]
    assert (found.candidate_effect.effect.name, found.candidate_effect.where) == (effect, where)
    assert found.probability > 0.9


def test_a_trackers_scale_is_certainly_one_of_lengths_and_not_certainly_the_trackers():
    effects = {"tracker_scale:measuring_system": 5e-4}
    made = simulate(find_robot("panda"), kind="point", poses=40, effects=effects, seed=3)
    found = examine(made.dataset, SCALES + kinds("link_geometry", "joint_offset", "joint_compliance"), seed=0)
    (one,) = found.findings
    assert one.candidate_effect.effect.name in {"tracker_scale", "arm_scale"}
    assert {each.name: each.probability for each in found.classes}["measuring_system"] > 0.99


def test_a_small_scale_beside_a_large_effect_is_found_where_it_predicts_new_poses():
    effects = {"joint_coupling:panda_joint2": 1.5e-3, "tracker_scale:measuring_system": 3e-5}
    noise = Noise(point_m=2e-5, joint_rad=1e-5)
    made = simulate(find_robot("panda"), kind="point", poses=24, noise=noise, effects=effects, seed=1)
    found = examine(made.dataset, SCALES + FOLLOWING + kinds("joint_compliance"), seed=1)
    assert {each.name: each.probability for each in found.classes}["measuring_system"] > 0.9
    assert found.gap.after_m < 1.1 * found.gap.noise_floor_m


@pytest.mark.parametrize(
    ("effects", "classes"),
    [
        ({"joint_compliance": 2e-5, "joint_offset:panda_joint4": 3e-3}, {"elasticity", "arm_geometry"}),
        (
            {"joint_compliance:panda_joint2": 6e-6, "encoder_eccentricity:panda_joint2": 4e-3},
            {"elasticity", "transmission"},
        ),
    ],
    ids=["a zero", "a reading with one period per turn"],
)
def test_what_yields_beside_a_far_larger_cause_at_its_joint_is_no_form_of_it(effects, classes):
    """It explains fifty times less, and yet new poses are predicted much worse without it."""
    made = simulate(find_robot("panda"), kind="point", poses=50, noise=Noise(point_m=3e-5), effects=effects, seed=1)
    found = examine(made.dataset, ELASTIC + FOLLOWING, seed=0)
    assert found.verdict == "explained"
    assert {one.name for one in found.classes if one.probability > 0.9} >= classes
    assert found.gap.after_m < 1.1 * found.gap.noise_floor_m


def test_a_wrong_zero_beside_little_that_follows_another_joint_is_no_coupling():
    """A coupled joint is off by its zero no farther than the other joint turns, times the ratio."""
    effects = {"joint_offset:panda_joint4": 2e-3}
    made = simulate(find_robot("panda"), kind="point", poses=40, noise=Noise(point_m=3e-5), effects=effects, seed=1)
    poses = made.dataset.poses
    q = poses.q.copy()
    q[:, 3] -= 6e-5 * np.tanh(3.0 * poses.q[:, 2])
    found = examine(replace(made.dataset, poses=replace(poses, q=q)), FOLLOWING, seed=0)
    sure = {str(one.candidate_effect) for one in found.findings if one.probability > 0.9}
    assert "joint_offset at panda_joint4" in sure
    assert not any(name.startswith("joint_coupling") for name in sure)


def test_what_yields_to_the_load_of_another_joint_is_an_unknown_cause_that_depends_on_that_load():
    made = simulate(find_robot("ur5"), kind="point", poses=40, noise=Noise(point_m=2e-5), seed=8).dataset
    poses = made.poses
    q = poses.q.copy()
    q[:, 3] -= 5e-4 * np.cos(q[:, 1] + q[:, 2])
    found = examine(replace(made, poses=replace(poses, q=q)), ELASTIC + FOLLOWING, seed=0)
    assert [one.name for one in found.classes] == ["unknown"]
    assert (found.where[0].site, found.where[0].coordinate) == ("wrist_1_joint", "gravity torque at elbow_joint")


@pytest.mark.parametrize("lifts", [True, False], ids=["a plate that lifts", "three feet"])
def test_a_stand_that_does_not_yield_alike_to_all_loads_is_an_unknown_cause_at_the_base(lifts):
    """It leans to where the arm's weight is: beyond a preload alone, or three times as far between two of its feet."""
    made = simulate(find_robot("ur5"), kind="point", poses=40, noise=Noise(point_m=3e-5), seed=2)
    model = pinocchio.buildModelFromXML(made.dataset.robot.urdf)
    data = model.createData()
    weight = np.array([pinocchio.centerOfMass(model, data, q).copy() for q in made.dataset.poses.q]) * [1.0, 1.0, 0.0]
    out = np.linalg.norm(weight, axis=1, keepdims=True)
    azimuth = np.arctan2(weight[:, [1]], weight[:, [0]])
    angle = 6e-3 * np.maximum(out - np.median(out), 0.0) if lifts else 1e-3 * out * (2.0 + np.cos(3.0 * azimuth))
    turn = (angle * np.cross([0.0, 0.0, 1.0], weight / out))[made.dataset.points.pose]
    R = from_angles(*(np.array(made.truth[f"base.{angle}"]) for angle in ("w", "phi", "psi")))
    measured = made.dataset.points["xyz"]
    from_base = (measured - [made.truth[f"base.{axis}"] for axis in "xyz"]) @ R
    leant = measured + np.cross(turn, from_base) @ R.T
    seen = replace(made.dataset, points=replace(made.dataset.points, xyz=leant))
    found = examine(seen, ELASTIC + kinds("link_geometry", "joint_offset"), seed=0)
    assert {one.name: one.probability for one in found.classes}["unknown"] > 0.8
    assert not [one for one in found.findings if one.probability > 0.9]
    assert (found.where[0].site, found.where[0].coordinate) == ("base", "overturning moment")
