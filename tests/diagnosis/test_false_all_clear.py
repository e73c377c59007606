"""What errs by more than noise is a gap, also where every pose errs by chance."""

import json
from dataclasses import replace
from functools import cache
from importlib.resources import files

import jsonschema
import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from robolaser import load
from robolaser.data.dataset import Dataset
from robolaser.data.stated_noise import Noise
from robolaser.data.writing import save
from robolaser.diagnosis import Diagnosis, examine
from robolaser.diagnosis.result_json import diagnosis_json
from robolaser.errors import DataError
from robolaser.report.diagnosis.advice import to_do
from robolaser.robot.by_name import find_robot
from robolaser.simulation import CellOptions, simulate

STATED = {
    "stripe": Noise(pixel_px=0.1, target_m=3e-5),
    "point": Noise(point_m=2e-5),
    "camera": Noise(pixel_px=0.1),
    "pose": Noise(point_m=2e-5, angle_rad=5e-5),
}
POINTS = {"stripe": 8, "point": 3, "camera": 12, "pose": 1}


def measured(kind: str, joint_rad: float, seed: int = 1, poses: int = 40, **stated: float) -> Dataset:
    noise = STATED[kind]
    dataset = simulate(
        find_robot("ur5"), kind=kind, poses=poses, points=POINTS[kind], noise=replace(noise, joint_rad=joint_rad),
        options=CellOptions(stated=noise), seed=seed,
    ).dataset  # fmt: skip
    return replace(dataset, noise=replace(dataset.noise, **stated))


@cache
def scattered(kind: str, joint_rad: float) -> Diagnosis:
    return examine(measured(kind, joint_rad), effects=[], seed=0)


@pytest.mark.parametrize(("kind", "joint_rad"), [("stripe", 1e-3), ("point", 5e-3), ("pose", 5e-3)])
def test_joints_that_scatter_more_than_arms_do_are_a_gap(kind: str, joint_rad: float) -> None:
    found = scattered(kind, joint_rad)
    assert found.verdict == "unexplained"
    assert found.gap.after_m > found.gap.noise_floor_m
    scatter = found.pose_scatter
    assert scatter.where == "joints"
    assert scatter.sizes["turn"].value == pytest.approx(joint_rad, abs=4 * scatter.sizes["turn"].std)
    assert scatter.sizes["turn"].std < 0.1 * joint_rad


@pytest.mark.parametrize("kind", STATED)
def test_joints_that_scatter_as_arms_do_are_none(kind: str) -> None:
    found = scattered(kind, 1e-4)
    assert found.verdict == "no_gap"
    assert found.pose_scatter is None


def test_the_scatter_is_said_where_it_is_and_what_it_may_be() -> None:
    found = scattered("point", 5e-3)
    assert "Joint readings scatter by 0.3" in found.sentence
    assert "were they read before the arm had stopped? Are these commanded angles?" in found.sentence
    assert "how well the arm" not in found.sentence
    assert any("after the arm has stopped" in one for one in to_do(found))
    assert not any("gear" in one for one in to_do(found))
    written = diagnosis_json(found)
    jsonschema.validate(written, json.loads(files("robolaser.schemas").joinpath("diagnosis.schema.json").read_text()))
    (effect,) = written["effects"]
    assert (effect["effect"], effect["where"], written["where"][0]["site"]) == ("pose_scatter", "joints", "joints")
    assert effect["gap_mm_before"] == effect["gap_mm_after"]
    assert written["classes"][0]["class"] == "repeatability"


def test_a_single_joint_that_scatters_is_named() -> None:
    dataset = measured("point", 1e-6)
    poses, joint = dataset.poses, dataset.robot.joints[2]
    q = poses.q.copy()
    q[:, 2] += 3e-3 * np.random.default_rng(3).normal(size=len(q))
    found = examine(replace(dataset, poses=replace(poses, q=q)), effects=[], seed=0)
    assert found.verdict == "unexplained"
    assert found.pose_scatter.where == joint
    assert found.pose_scatter.probability > 0.9
    assert f"Readings of {joint} scatter by" in found.sentence


@pytest.mark.parametrize(("repeatability_m", "verdict"), [(2e-5, "unexplained"), (1e-3, "no_gap")])
def test_scatter_is_compared_with_the_data_sheet_where_it_is_stated(repeatability_m: float, verdict: str) -> None:
    found = examine(measured("point", 1e-4, repeatability_m=repeatability_m), effects=[], seed=0)
    assert found.verdict == verdict
    said = "by 0.006°, more than the stated repeatability of 0.02 mm (0.0014°)"
    assert (said in found.sentence) is (verdict == "unexplained")


def test_an_arm_of_large_stated_repeatability_may_scatter_more_than_others_do() -> None:
    found = examine(measured("point", 1e-3, repeatability_m=3e-3), effects=[], seed=0)
    assert found.verdict == "no_gap"
    assert found.pose_scatter is None


def test_the_repeatability_of_the_data_sheet_is_read_checked_and_written(tmp_path) -> None:
    save(measured("point", 1e-4, repeatability_m=2e-5), tmp_path / "set")
    assert load(tmp_path / "set").noise.repeatability_m == 2e-5
    file = tmp_path / "set" / "dataset.toml"
    file.write_text(file.read_text().replace("repeatability_m = 2e-05", "repeatability_m = -1"))
    with pytest.raises(DataError, match="repeatability_m: -1, expected a positive number"):
        load(tmp_path / "set")


def test_noise_that_is_stated_too_large_is_not_what_the_error_would_be_below() -> None:
    dataset = replace(measured("stripe", 1e-6), noise=Noise(pixel_px=0.3, target_m=9e-5))
    found = examine(dataset, effects=[], seed=0)
    assert found.gap.after_ci95_m[1] < found.gap.noise_floor_m
    assert "noise alone" not in found.sentence
    assert f"less than the assumed noise ({1e3 * found.gap.noise_floor_m:.3g} mm)" in found.sentence


MOVED = {
    "drift": lambda progress: 3e-3 * progress,
    "step": lambda progress: 3e-3 * (progress > 0.6),
    "sway": lambda progress: 3e-4 * np.sin(6.0 * np.pi * progress),
}


@pytest.mark.parametrize("form", MOVED)
def test_what_moves_in_the_course_of_a_campaign_is_no_scatter_of_poses(form: str) -> None:
    data = measured("point", 1e-5)
    moved = MOVED[form](data.points.pose / (len(data.poses) - 1))
    wrong = replace(data, points=replace(data.points, xyz=data.points.xyz + moved[:, None] * [0.6, 0.0, 0.8]))
    found = diagnosis_json(examine(wrong, effects=[], seed=0))
    assert found["verdict"] == "unexplained"
    assert found["where"][0]["coordinate"] == "time"
    assert not [one for one in found["effects"] if one["effect"] == "pose_scatter" and one["probability"] >= 0.5]


def test_a_stand_that_sways_along_one_line_is_seen_within_the_usual_scatter_of_poses() -> None:
    data = measured("point", 1e-5, poses=80)
    sight = data.points.xyz.mean(axis=0)
    across = np.cross(sight, [0.0, 0.0, 1.0]) / np.linalg.norm(sight)  # along the line of sight a range may be wrong
    moved = 6e-5 * np.sin(10.6 * np.pi * data.points.pose / (len(data.poses) - 1))
    wrong = replace(data, points=replace(data.points, xyz=data.points.xyz + moved[:, None] * across))
    found = examine(wrong, effects=[], seed=0)
    assert found.verdict == "unexplained"
    assert (found.where[0].site, found.where[0].coordinate) == ("base", "time")


def test_a_reflector_of_a_wrong_range_constant_is_no_noise_of_all() -> None:
    data = measured("point", 1e-5)
    name = data.points.names[1]
    farther = 3e-4 * np.array([one == name for one in data.points.names])
    sight = data.points.xyz / np.linalg.norm(data.points.xyz, axis=1, keepdims=True)
    wrong = replace(data, points=replace(data.points, xyz=data.points.xyz + farther[:, None] * sight))
    found = examine(wrong, effects=[], seed=0)
    assert found.verdict == "unexplained"
    assert (found.where[0].site, found.where[0].coordinate) == ("tool", f"direction of view of {name}")


def test_a_few_poses_far_off_are_no_repeatability_of_all() -> None:
    data, rng = measured("point", 1e-5), np.random.default_rng(0)
    odd = rng.choice(len(data.poses), 6, replace=False)
    moved = np.zeros((len(data.poses), 3))
    moved[odd] = rng.normal(0.0, 1e-3, (6, 3))
    wrong = replace(data, points=replace(data.points, xyz=data.points.xyz + moved[data.points.pose]))
    found = examine(wrong, effects=[], seed=0)
    assert found.verdict == "unexplained"
    worst = data.poses.names[np.linalg.norm(moved, axis=1).argmax()]
    assert f"Most of the error is at poses {worst}" in found.sentence or len(found.outliers)


def test_a_ripple_of_another_form_than_gears_have_is_neither_noise_nor_scatter() -> None:
    data = measured("point", 1e-6, poses=100)
    assert data.poses.q is not None
    q = data.poses.q.copy()
    q[:, 1] += 6e-4 * np.sign(np.sin(100.0 * q[:, 1]))
    found = examine(replace(data, poses=replace(data.poses, q=q)), seed=0)
    assert found.verdict == "unexplained"
    assert found.where[0].site == "shoulder_lift_joint"
    assert "periodic in the motor's angle" in found.where[0].coordinate
    assert "resembles an effect" in " ".join(to_do(found))


@cache
def turned() -> Diagnosis:
    """Measured flange poses whose rotations alone are wrong: with the sine of an angle."""
    data = measured("pose", 1e-5)
    turn = Rotation.from_rotvec(4e-3 * np.sin(data.poses.q[:, [4]]) * [1.0, 0.0, 0.0])
    quaternion = (Rotation.from_quat(data.points.columns["quaternion"]) * turn[data.points.pose]).as_quat()
    points = replace(data.points, columns={**data.points.columns, "quaternion": quaternion})
    return examine(replace(data, points=points), effects=[], seed=0)


def test_rotations_that_are_wrong_are_a_gap_though_positions_are_right() -> None:
    assert turned().verdict == "unexplained"


def test_a_gap_that_is_no_chance_is_not_held_against_scatter_that_was_estimated_from_it() -> None:
    found = turned()
    assert found.gap.noise_floor_m < found.gap.after_m or "yet not random" in found.sentence
