"""Columns that are exchanged, turned round or in degrees, and reflectors named in another order: noticed, and named."""

from collections.abc import Callable
from dataclasses import replace

import numpy as np
import pytest
from cells import on_flange_poses
from several import two_trackers

import robolaser
from robolaser import calibrate
from robolaser.arrays import Array
from robolaser.calibration.misread import misread
from robolaser.calibration.other_readings import exchanged_points, with_names, with_rows_moved
from robolaser.calibration.plan import Plan
from robolaser.data.dataset import Dataset, Poses
from robolaser.data.loading import load
from robolaser.data.stated_noise import Noise
from robolaser.data.writing import save
from robolaser.diagnosis import examine
from robolaser.diagnosis.preparation import Preparation
from robolaser.diagnosis.result_json import diagnosis_json
from robolaser.errors import DataError, EstimationError
from robolaser.geometry.rigid_motion import rot_x, rot_z
from robolaser.model.effects import EFFECTS
from robolaser.model.forward_model import Model
from robolaser.model.sensors.in_cell import Mounting
from robolaser.robot.by_name import find_robot
from robolaser.robot.kinematics import Robot
from robolaser.simulation import CellOptions, simulate

SUSPECTS = [one for one in EFFECTS if one.name in ("joint_offset", "encoder_scale", "link_geometry", "backlash")]
"""What a slip might be taken for."""
DEGREES = 180.0 / np.pi
SLIPS: dict[str, tuple[Callable[[Array], Array], str]] = {
    "exchanged": (
        lambda q: q[:, [0, 2, 1, *range(3, q.shape[1])]],
        "The columns q_{1} and q_{2} of poses.csv seem to be",
    ),
    "turned round": (
        lambda q: q * np.where(np.arange(q.shape[1]) == 3, -1.0, 1.0),
        "q_{3} seems to have the wrong sign",
    ),
    "in degrees": (lambda q: q * np.where(np.arange(q.shape[1]) == 4, DEGREES, 1.0), "q_{4} seems to be in degrees"),
    "a row early": (
        lambda q: np.where(np.arange(q.shape[1]) == 3, np.roll(q, -1, axis=0), q),
        "The readings of q_{3} seem to belong to the pose after theirs",
    ),
    "all in radians taken for degrees": (lambda q: q / DEGREES, "All angles of poses.csv seem to be divided by 57.3"),
}


def slipped(dataset: Dataset, slip: str) -> tuple[Dataset, str]:
    robot, q = dataset.arm
    change, said = SLIPS[slip]
    return replace(dataset, poses=replace(dataset.poses, q=change(q))), said.format(*robot.joints)


@pytest.mark.parametrize(("slip", "kind"), [("exchanged", "stripe"), *((slip, "socket") for slip in [*SLIPS][1:])])
def test_the_slip_is_found_by_what_it_does_to_the_fit(slip: str, kind: str) -> None:
    sound = simulate("scorbot_er7", kind=kind, poses=10, effects={"joint_offset:joint_2": 0.002})
    wrong, said = slipped(sound.dataset, slip)
    found = misread(Model(wrong), rms_m=0.1)
    assert said in found.sentence
    assert found.shift == 0


def test_rows_of_one_sensor_that_are_one_pose_off_are_told_by_its_file() -> None:
    both = on_flange_poses(two_trackers(8))
    found = misread(Model(with_rows_moved(both, -1, of=both.sensors[1].rows)), rms_m=0.1)
    assert "All rows of right.csv seem to belong to the pose after theirs" in found.sentence
    assert found.shift == 1


def test_a_wrong_cell_with_joints_read_rightly_is_not_blamed_on_them() -> None:
    sound = simulate(find_robot("scorbot_er7"), kind="stripe", poses=12, seed=1).dataset
    points = sound.points
    wrong = replace(sound, points=replace(points, xyz=points.xyz[:, [1, 0, 2]]))
    assert "q_" not in misread(Model(wrong), rms_m=0.1).sentence


def test_millimetres_are_no_sign_of_it_and_nothing_is_tried() -> None:
    wrong, _ = slipped(simulate(find_robot("ur5e"), kind="point", poses=15).dataset, "exchanged")
    assert misread(Model(wrong), rms_m=0.009) is None


def test_a_calibration_warns_of_it_first() -> None:
    wrong, said = slipped(simulate("scorbot_er7", kind="socket", poses=10).dataset, "exchanged")
    assert said in calibrate(wrong, Plan()).warnings[0]


def test_it_is_said_where_no_fit_is_found_at_all() -> None:
    noise = Noise(pixel_px=0.1, joint_rad=1e-5)
    wrong, said = slipped(simulate("ur5e", kind="camera", poses=14, noise=noise, seed=2).dataset, "exchanged")
    with pytest.raises(EstimationError) as refusal:
        calibrate(wrong, Plan())
    assert str(refusal.value).startswith(said)
    assert "instead of" not in str(refusal.value)


def test_a_diagnosis_says_it_first_and_what_is_left_is_neither_noise_nor_the_work_of_an_effect() -> None:
    noise = Noise(point_m=3e-5)
    wrong, said = slipped(simulate("scorbot_er7", kind="socket", poses=12, noise=noise, seed=2).dataset, "exchanged")
    found = examine(wrong, SUSPECTS)
    assert found.sentence.startswith(said)
    assert found.verdict == "unexplained"
    assert not found.findings


def test_readings_within_their_limits_only_once_two_columns_are_exchanged_raise_the_question(tmp_path) -> None:
    sound = simulate(find_robot("fr3"), kind="point", poses=10).dataset
    q = sound.arm[1].copy()
    q[:, 0], q[:, 1:3], q[:, 4] = 1.9, 0.0, 0.5
    save(replace(sound, poses=replace(sound.poses, q=q[:, [0, 1, 2, 5, 4, 3, 6]])), tmp_path / "wrong")
    with pytest.raises(DataError, match=r"Are the columns q_fr3_joint4 and q_fr3_joint6 exchanged\?"):
        load(tmp_path / "wrong")


def test_where_no_reading_fits_none_is_accused(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("robolaser.calibration.misread._error", lambda dataset: np.inf)
    assert misread(Model(simulate(find_robot("scorbot_er7"), poses=8, seed=1).dataset), np.inf) is None


def test_rows_that_are_one_pose_off_are_named() -> None:
    data = simulate("scorbot_er7", kind="point", poses=15, noise=Noise(point_m=3e-5), seed=1).dataset
    found = diagnosis_json(examine(with_rows_moved(data, -1), SUSPECTS, seed=0))
    assert "seem to belong to the pose" in found["sentence"]
    assert (found["effects"][0]["effect"], found["effects"][0]["where"]) == ("mispaired", "image")
    assert [one["site"] for one in found["where"]] == ["image"]
    assert found["where"][0]["share"] > 0.96
    assert found["effects"][0]["parameters"]["poses"]["value"] == 1
    assert found["verdict"] == "unexplained"
    assert found["classes"][0]["class"] == "measuring_system"


@pytest.mark.parametrize(
    ("kind", "shift", "lost", "seen"),
    [("point", -1, 13, 1.0), ("camera", 1, 13, 1.0), ("camera", -1, 11, 0.3), ("pose", -1, 7, 1.0)],
)
def test_where_a_pose_or_an_image_was_lost_is_named(kind: str, shift: int, lost: int, seen: float) -> None:
    noise = Noise(point_m=3e-5, pixel_px=0.1, angle_rad=1e-4)
    data = simulate(find_robot("ur5"), kind=kind, poses=20, noise=noise, seed=1).dataset
    shown = np.random.default_rng(0).random(len(data.points)) < seen  # an image may show a part of the board
    kept = np.flatnonzero(((data.points.pose != lost) | (shift < 0)) & shown)
    moved = on_flange_poses(with_rows_moved(replace(data, parameters={}, points=data.points.take(kept)), -shift, lost))
    found = misread(Model(moved), rms_m=0.5)
    assert found.shift == shift
    first = found.sentence.partition("From pose ")[2].partition(" on, ")[0]
    assert abs(data.poses.names.index(first) - lost) <= 1
    if kind == "point":
        assert not Preparation.of(moved, 0).belongs


def test_rows_that_slipped_and_slipped_back_are_named_from_pose_to_pose() -> None:
    data = simulate("scorbot_er7", kind="point", poses=24, noise=Noise(point_m=3e-5), seed=1).dataset
    lost = replace(data, points=data.points.take(np.flatnonzero(data.points.pose != 8)))
    found = misread(Model(on_flange_poses(with_rows_moved(lost, -1, 9, 15))), rms_m=0.5)
    first, last = found.sentence.partition("From pose ")[2].partition(", ")[0].split(" to pose ")
    assert abs(data.poses.names.index(first) - 8) <= 1
    assert abs(data.poses.names.index(last) - 14) <= 1
    assert found.shift == 1


def test_inverse_flange_poses_are_named() -> None:
    data = simulate("scorbot_er7", kind="camera", poses=10, points=8, noise=Noise(pixel_px=0.1), seed=1).dataset
    T = np.linalg.inv(data.flange())
    wrong = replace(data, robot=None, poses=Poses(data.poses.names, T_base_flange=T))
    assert "inverse" in misread(Model(wrong), rms_m=0.5).sentence


def test_a_camera_at_the_other_end_is_named() -> None:
    data = simulate("scorbot_er7", kind="camera", poses=10, points=8, noise=Noise(pixel_px=0.1), seed=1).dataset
    found = misread(Model(replace(data, options=Mounting("base"), parameters={}, placed=False)), rms_m=0.5)
    assert "mounted on the flange" in found.sentence


def mirrored(values: Array) -> Array:
    return values[:, [1, 0, 2]]


TRACKED = {
    "in inches": (lambda xyz: xyz / 0.0254, "in inches"),
    "in millimetres": (lambda xyz: xyz * 1e3, "in millimetres"),
    "in inches, read as millimetres": (lambda xyz: xyz / 25.4, "in inches, read as millimetres"),
    "in millimetres, read as inches": (lambda xyz: xyz * 25.4, "in millimetres, read as inches"),
    "left-handed": (mirrored, "in a left-handed frame"),
}
ALIKE = ["in inches, read as millimetres", "in millimetres, read as inches", "in millimetres", "left-handed"]
"""What flange poses read otherwise explain as well."""


@pytest.mark.parametrize("slip", ["in inches", "left-handed"])
def test_points_in_another_unit_or_frame_are_named(slip: str) -> None:
    sound = simulate("scorbot_er7", kind="point", poses=10, noise=Noise(point_m=3e-5), seed=1).dataset
    change, said = TRACKED[slip]
    found = misread(Model(replace(sound, points=replace(sound.points, xyz=change(sound.points.xyz)))), rms_m=0.5)
    assert f"The points seem to be {said}" in found.sentence


@pytest.mark.parametrize(
    ("kind", "slip"), [("camera", "in inches"), ("stripe", "in millimetres"), ("stripe", "left-handed")]
)
def test_a_target_in_another_unit_or_frame_is_named(kind: str, slip: str) -> None:
    sound = simulate("scorbot_er7", kind=kind, poses=10, points=8, noise=Noise(pixel_px=0.1), seed=1).dataset
    change, said = {**TRACKED, "left-handed": (lambda xyz: xyz * (-1.0, 1.0, 1.0), "in a left-handed frame")}[slip]
    found = misread(Model(replace(sound, points=replace(sound.points, xyz=change(sound.points.xyz)))), rms_m=0.5)
    assert f"points of the target seem to be {said}" in found.sentence


@pytest.mark.parametrize("kind", ["camera", "stripe"])
def test_a_target_in_a_frame_of_its_own_is_named(kind: str) -> None:
    sound = simulate("scorbot_er7", kind=kind, poses=12, points=8, noise=Noise(pixel_px=0.1), seed=1).dataset
    turned = sound.points.xyz @ rot_x(0.7).T @ rot_z(1.1).T + (0.1, -0.2, 0.3)
    found = misread(Model(replace(sound, points=replace(sound.points, xyz=turned))), rms_m=0.5)
    assert found.sentence.startswith("The points of the target seem to be in a frame of its own")
    assert "Correct placed under [target]" in found.sentence


def test_known_distances_in_another_unit_are_named() -> None:
    sound = simulate("scorbot_er7", kind="socket", poses=20, noise=Noise(joint_rad=2e-5), seed=1).dataset
    inches = tuple((one, other, distance / 0.0254) for one, other, distance in sound.distances_m)
    found = misread(Model(replace(sound, distances_m=inches)), rms_m=0.5)
    assert found.sentence.startswith("The known distances seem to be in inches")


def reflected(dataset: Dataset) -> Dataset:
    pixel = dataset.points["pixel"] * (-1.0, 1.0) + (dataset.image_px[0] - 1.0, 0.0)
    return replace(dataset, points=replace(dataset.points, pixel=pixel))


def with_exchanged_pixels(dataset: Dataset) -> Dataset:
    return replace(dataset, points=replace(dataset.points, pixel=dataset.points["pixel"][:, ::-1].copy()))


IMAGES = {
    "mirrored": (reflected, "the images seem to be mirrored"),
    "exchanged": (with_exchanged_pixels, "columns u_px and v_px of points.csv seem to be exchanged"),
}


@pytest.mark.parametrize(("kind", "slip"), [("camera", "mirrored"), ("camera", "exchanged"), ("stripe", "mirrored")])
def test_images_with_other_axes_are_named(kind: str, slip: str) -> None:
    sound = simulate("scorbot_er7", kind=kind, poses=10, points=8, noise=Noise(pixel_px=0.1), seed=1).dataset
    change, said = IMAGES[slip]
    assert said in misread(Model(change(sound)), rms_m=0.5).sentence.lower()


def test_the_other_axis_of_a_stripe_is_named() -> None:
    sound = simulate("scorbot_er7", poses=10, points=8, noise=Noise(pixel_px=0.1), seed=1).dataset
    found = misread(Model(replace(sound, stripe_axis="v")), rms_m=0.5)
    assert found.sentence.startswith('stripe_axis seems to be "u", and not "v"')


def test_points_that_fit_no_pose_are_not_in_a_smaller_unit_although_all_errors_would_shrink() -> None:
    wrist = find_robot("scorbot_er7", flange="flange", joints=("joint_4", "joint_5"))  # axes that meet: no length
    sound = simulate(wrist, kind="point", poses=12, noise=Noise(point_m=3e-5), seed=1).dataset
    shuffled = np.random.default_rng(1).permutation(len(sound.poses))
    moved = replace(sound.points, pose=shuffled[sound.points.pose])
    assert misread(Model(replace(sound, points=moved)), rms_m=0.5) is None


@pytest.mark.parametrize("slip", ALIKE)
def test_where_flange_poses_explain_it_as_well_as_points_both_are_named(slip: str) -> None:
    sound = simulate("scorbot_er7", kind="point", poses=10, noise=Noise(point_m=3e-5), seed=1).dataset
    change, said = TRACKED[slip]
    wrong = replace(sound, points=replace(sound.points, xyz=change(sound.points.xyz)))
    found = misread(Model(on_flange_poses(wrong)), rms_m=0.5)
    assert f"The points seem to be {said}" in found.sentence
    assert "flange" in found.sentence
    assert "Correct one of the two." in found.sentence


@pytest.mark.parametrize("stated", ["ur5e", "ur3", "ur10"])
def test_another_size_or_generation_of_the_arm_is_named(stated: str) -> None:
    sound = simulate(find_robot("ur5"), kind="point", poses=25, noise=Noise(point_m=3e-5), seed=1).dataset
    found = misread(Model(replace(sound, robot=find_robot(stated))), rms_m=0.005)
    assert f"a Universal Robots UR5, and not the {stated}" in found.sentence


@pytest.mark.parametrize("moved_by", [3, 5])
def test_another_flange_is_named(moved_by: int) -> None:
    sound = simulate(find_robot("ur5e"), kind="point", poses=15, noise=Noise(point_m=3e-5), seed=1).dataset
    robot, _ = sound.arm
    behind = [link.name for link in robot.by_pinocchio.links if link.joint is not None]
    stated = Robot.from_urdf(robot.urdf, flange=behind[moved_by - 1], joints=robot.joints)
    found = misread(Model(replace(sound, robot=stated)), rms_m=0.5)
    assert found.sentence.startswith(
        f"What is on the flange seems to be on {behind[-1]}, and not on {behind[moved_by - 1]}"
    )


def test_an_arm_that_is_off_by_millimetres_is_no_other_arm() -> None:
    off = {"joint_offset:elbow_joint": 0.005, "link_geometry:wrist_1_joint": 0.004}
    data = simulate(find_robot("ur5"), kind="point", poses=25, noise=Noise(point_m=3e-5), effects=off, seed=1).dataset
    assert misread(Model(data), rms_m=0.005) is None


def transposed(T: Array) -> Array:
    read = T.copy()
    read[:, :3, :3] = np.swapaxes(T[:, :3, :3], 1, 2)
    return read


def left_handed(T: Array) -> Array:
    sides = np.array([1.0, 1.0, -1.0, 1.0])
    return T * sides[:, None] * sides


FLANGE = {"transposed": transposed, "left-handed": left_handed, "in inches": lambda T: T * inches()}


def inches() -> Array:
    factors = np.ones((4, 4))
    factors[:3, 3] = 1.0 / 0.0254
    return factors


@pytest.mark.parametrize("slip", FLANGE)
def test_flange_poses_in_another_form_are_named(slip: str) -> None:
    sound = simulate("ur5", kind="camera", poses=10, points=8, seed=2).dataset
    T = FLANGE[slip](np.asarray(sound.flange()))
    wrong = replace(sound, robot=None, poses=Poses(sound.poses.names, T_base_flange=T))
    assert slip in misread(Model(wrong), rms_m=0.5).sentence


def test_rows_that_slipped_in_one_of_two_sessions_are_told_by_its_pose() -> None:
    options, noise = CellOptions(sessions=2), Noise(point_m=3e-5)
    both = on_flange_poses(simulate("scorbot_er7", kind="point", poses=19, options=options, noise=noise).dataset)
    second = np.flatnonzero(both.session_of_pose[both.points.pose] == 1)
    found = misread(Model(with_rows_moved(both, 1, 19, of=second)), rms_m=0.1)
    expected = "From pose session-2/0 on, the points, or images, seem to belong to the pose before theirs"
    assert expected in found.sentence


def test_rows_that_lie_at_other_poses_without_order_end_a_diagnosis_soon() -> None:
    made = simulate("scorbot_er7", kind="stripe", poses=10, points=4, noise=Noise(pixel_px=0.2), seed=3).dataset
    shuffled = np.random.default_rng(1).permutation(len(made.poses))
    wrong = replace(made, points=replace(made.points, pose=shuffled[made.points.pose]))
    found = examine(on_flange_poses(wrong))
    assert (found.verdict, found.findings) == ("unexplained", ())


def measured() -> Dataset:
    return simulate("ur5", kind="point", poses=40, noise=Noise(point_m=3e-5), seed=2).dataset


def exchanged(data: Dataset, poses: list[int]) -> Dataset:
    a, b, _ = dict.fromkeys(data.points.names)
    return with_names(data, {pose: {a: b, b: a} for pose in poses})


def test_where_names_are_right_nothing_is_said() -> None:
    assert exchanged_points(measured()) == {}


@pytest.mark.parametrize("poses", [[3], [0, 7, 8, 30], list(range(0, 30, 2))])
def test_exchanged_names_are_put_right(poses: list[int]) -> None:
    data = measured()
    wrong = exchanged(data, poses)
    found = exchanged_points(wrong)
    assert sorted(found) == poses
    assert with_names(wrong, found).points.names == data.points.names


def test_three_names_may_have_gone_round() -> None:
    data = measured()
    a, b, c = dict.fromkeys(data.points.names)
    wrong = with_names(data, {5: {a: b, b: c, c: a}})
    assert with_names(wrong, exchanged_points(wrong)).points.names == data.points.names


def test_a_body_whose_distances_are_alike_says_nothing() -> None:
    data = measured()
    number = np.array([sorted(set(data.points.names)).index(name) for name in data.points.names])
    triangle = 0.1 * np.array([[1.0, 0.0, 0.0], [-0.5, np.sqrt(0.75), 0.0], [-0.5, -np.sqrt(0.75), 0.0]])
    alike = replace(data, points=replace(data.points, xyz=triangle[number]))
    assert exchanged_points(exchanged(alike, [1, 2])) == {}


def test_the_diagnosis_says_which_points_of_which_poses() -> None:
    found = robolaser.diagnose(exchanged(measured(), [3, 9, 12, 20, 31]), seed=0)
    assert "of poses 3, 9, 12, 20 and others seem to be exchanged: with that corrected" in found.sentence
    assert found.effects == []
