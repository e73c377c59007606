"""Data that lack something: a diagnosis does what they allow, and says what they do not."""

import json
import re
from dataclasses import replace
from functools import cache

import numpy as np
import pytest
from asked import simulate_as_asked
from cells import on_flange_poses

from robolaser.data.stated_noise import Noise
from robolaser.data.subsampling import MAX_POSES, chosen_rows
from robolaser.diagnosis import examine
from robolaser.diagnosis.data_check import check_data
from robolaser.diagnosis.result_json import diagnosis_json
from robolaser.model.effects import EFFECTS
from robolaser.model.forward_model import Model
from robolaser.robot.by_name import find_robot
from robolaser.robot.kinematics import Robot

NOISE = Noise(pixel_px=0.1, target_m=3e-5, joint_rad=1e-5, point_m=2e-5)
FEW = (
    "joint_offset", "encoder_scale", "joint_compliance", "backlash", "latency", "base_shift", "thermal_drift",
    "laser_roll",
)  # fmt: skip
TESTED = [kind for kind in EFFECTS if kind.name in FEW]
"""Enough of the library to see each kind of reason."""
KINDS = ("camera", "point", "pose", "profile", "socket", "stripe")
POINTS = {"camera": 12, "stripe": 5}


@cache
def recorded(kind="stripe", **wanted):
    wanted = {"poses": 14, "points": POINTS.get(kind, 3), "noise": NOISE, "seed": 4} | wanted
    dataset = simulate_as_asked(find_robot("scorbot_er7"), kind=kind, **wanted).dataset
    if kind != "camera":  # which has no closed form for one or two poses
        return dataset
    items = Model(dataset).parameters.items
    return replace(dataset, parameters={item.name: replace(item, given=True) for item in items})


def answer(dataset, effects=TESTED):
    """Its answer, checked to be one that can be written."""
    diagnosis = examine(dataset, effects, seed=0)
    found = diagnosis_json(diagnosis)
    json.dumps(found, allow_nan=False)
    assert found["verdict"] in ("no_gap", "explained", "unexplained")
    assert diagnosis.sentence
    assert sum(lies["share"] for lies in found["where"]) <= 1.0 + 1e-9
    return found


def reasons(found):
    return {entry["effect"]: entry["reason"] for entry in found["not_testable"]}


def only(dataset, poses):
    chosen = np.zeros(len(dataset.poses), dtype=bool)
    chosen[:poses] = True
    return dataset.of_poses(chosen)


@pytest.mark.parametrize(
    ("kind", "poses"), [*((kind, 1) for kind in KINDS), ("point", 2), ("stripe", 2), ("stripe", 4)]
)
def test_too_few_poses_speak_for_no_effect(kind, poses):
    found = answer(only(recorded(kind), poses))
    assert not found["effects"]
    assert set(reasons(found)) == {one.name for one in TESTED if kind == "stripe" or one.site != "laser"}
    if kind != "socket":  # of which whole sockets are held out
        assert ("the model's error is" in found["sentence"]) == ("On new poses" in found["sentence"]) == (poses > 2)
        assert "too large" not in found["sentence"] or poses > 2


@pytest.mark.parametrize("kind", KINDS)
def test_poses_all_alike_speak_for_no_effect_of_the_joints(kind):
    dataset = recorded(kind)
    alike = replace(dataset.poses, q=np.repeat(dataset.poses.q[:1], len(dataset.poses), axis=0))
    found = answer(replace(only(dataset, 14), poses=alike, points=dataset.points.take(dataset.points.pose == 0)))
    assert not found["effects"]
    assert "encoder_scale" in reasons(found)


def test_the_same_pose_again_and_again_is_survived():
    dataset = recorded("point", noise=NOISE)
    same = dataset.points.pose == 0
    again = dataset.points.take(np.tile(np.flatnonzero(same), len(dataset.poses)))
    rng = np.random.default_rng(0)
    points = replace(
        again,
        pose=np.repeat(np.arange(len(dataset.poses)), same.sum()),
        xyz=again.xyz + 2e-5 * rng.standard_normal(again.xyz.shape),
    )
    alike = replace(dataset.poses, q=np.repeat(dataset.poses.q[:1], len(dataset.poses), axis=0))
    assert not answer(replace(dataset, poses=alike, points=points))["effects"]


def test_without_an_order_nothing_that_needs_it_is_tested():
    dataset = recorded()
    told = reasons(answer(replace(dataset, poses=replace(dataset.poses, time_s=None))))
    assert {"backlash", "base_shift", "thermal_drift"} <= set(told)
    assert "order" in told["base_shift"]


def test_without_a_known_path_no_backlash_is_tested():
    assert "path" in reasons(answer(replace(recorded(), path_known=False)))["backlash"]


def test_without_velocities_no_latency_is_tested():
    dataset = recorded()
    assert "velocities" in reasons(answer(replace(dataset, poses=replace(dataset.poses, qd=None))))["latency"]


def test_a_robot_without_masses_has_no_compliance_to_test():
    dataset = recorded()
    urdf = re.sub(r"<inertial>.*?</inertial>", "", dataset.robot.urdf, flags=re.DOTALL)
    light = Robot.from_urdf(urdf, flange=dataset.robot.flange, joints=dataset.robot.joints)
    assert "masses" in reasons(answer(replace(dataset, robot=light)))["joint_compliance"]


@pytest.mark.parametrize("kind", KINDS)
def test_measured_flange_poses_speak_for_no_joint(kind):
    dataset = recorded(kind)
    told = reasons(answer(on_flange_poses(dataset)))
    assert {"joint_offset", "encoder_scale", "joint_compliance", "latency"} <= set(told)


@pytest.mark.parametrize("kind", KINDS)
def test_no_part_is_missed_that_a_sensor_of_the_kind_cannot_have(kind):
    untestable = set(reasons(diagnosis_json(examine(only(recorded(kind), 3), EFFECTS, seed=0))))
    assert ("laser_roll" in untestable) == (kind == "stripe")
    assert ("target_warp" in untestable) == (kind in {"stripe", "camera"})
    assert ("tracker_scale" in untestable) == (kind in {"point", "pose", "profile"})


def test_an_unplaced_target_is_survived():
    answer(recorded(placed=False))


@pytest.mark.parametrize("kind", ["stripe", "point"])
def test_one_point_a_pose_is_enough_for_an_answer(kind):
    dataset = recorded(kind, poses=30)
    answer(replace(dataset, points=dataset.points.take(np.unique(dataset.points.pose, return_index=True)[1])))


@pytest.mark.parametrize("kind", KINDS)
def test_noise_that_nobody_stated_is_estimated(kind):
    noise = replace(NOISE, target_m=None) if kind == "camera" else NOISE  # its board's errors are those of all images
    found = answer(recorded(kind, poses=24, noise=noise, stated=Noise()))
    assert found["verdict"] == "no_gap"
    assert all(np.isfinite(source["value"]) for source in found["noise"].values())


def test_perfect_data_leave_no_gap():
    assert answer(recorded(noise=None, stated=Noise()))["gap_mm"]["after"] < 0.01


def test_columns_that_say_nothing_are_passed_over():
    dataset = recorded()
    n = len(dataset.poses)
    constant = {"temperature_c": np.full(n, 20.0), "payload_kg": np.zeros(n), "extra": {"operator": ("me",) * n}}
    answer(replace(dataset, poses=replace(dataset.poses, **constant)))


def test_a_pose_without_points_is_survived():
    dataset = recorded()
    answer(replace(dataset, points=dataset.points.take(dataset.points.pose != 3)))


def test_a_repeat_of_everything_once_is_survived():
    answer(recorded(repeats=1, stated=Noise()))


def test_large_data_keep_a_few_rows_of_many_poses():
    dataset = recorded("point", poses=8)
    rows = np.tile(np.arange(len(dataset.points)), 300)
    many = replace(dataset.points.take(rows), pose=np.repeat(np.arange(len(rows) // 3), 3))
    poses = dataset.poses.take(np.tile(np.arange(len(dataset.poses)), 300))
    kept = chosen_rows(replace(dataset, poses=poses, points=many), 0)
    assert len(np.unique(many.pose[kept])) == MAX_POSES
    assert kept.sum() == 3 * MAX_POSES
    assert chosen_rows(dataset, 0).all()


def test_more_poses_than_are_needed_are_survived():
    effects = [kind for kind in TESTED if kind.name == "joint_offset"]
    assert answer(recorded("socket", poses=MAX_POSES + 20, stated=Noise()), effects)["verdict"] == "no_gap"


@pytest.mark.parametrize("kind", ["point", "camera"])
def test_poses_that_are_all_alike_tell_nothing_and_others_are_named(kind):
    dataset = recorded(kind)
    rows = np.flatnonzero(dataset.points.pose == dataset.points.pose[0])
    points = replace(dataset.points.take(np.tile(rows, 14)), pose=np.repeat(np.arange(14), len(rows)))
    q = np.tile(dataset.poses.q[dataset.points.pose[0]], (14, 1))
    found = answer(replace(dataset, poses=replace(dataset.poses, q=q), points=points), EFFECTS)
    assert found["sentence"].startswith("All 14 poses are alike")
    assert (found["effects"], found["classes"], found["where"]) == ([], [], [])
    next_q = np.array([list(pose.values()) for pose in found["next_poses"]])
    assert len(next_q)
    assert np.abs(next_q - q[0]).max(axis=1).min() > 0.1


def test_more_shapes_than_poses_tell_apart_are_not_tried_and_how_many_poses_they_take_is_said():
    gear = [kind for kind in EFFECTS if kind.name == "transmission_error"]
    few, enough = (answer(recorded("point", poses=poses), gear) for poses in (12, 24))
    said = re.fullmatch(r"fewer than (\d+) poses with points differ", reasons(few)["transmission_error"])
    assert said
    assert 12 < int(said[1]) <= 24
    assert "transmission_error" not in reasons(enough)
    (checked,) = (one for one in check_data(recorded("point", poses=12)).effects if one.effect == "transmission_error")
    assert checked.reason == said[0]
    assert not checked.locations
