"""What a scene shows is where the models say it is."""

from dataclasses import replace

import numpy as np
import pytest
from scanned import calibrated as made
from scanned import dataset

from robolaser.cell.plan_validation import collision_model
from robolaser.data.cell_config import Box, Limits
from robolaser.data.dataset import Points, Poses
from robolaser.errors import DataError
from robolaser.geometry.camera import laser_plane
from robolaser.geometry.rigid_motion import apply, exp_so3, from_quaternion, inverse, pose
from robolaser.report.cell_poses import CellPoses
from robolaser.report.viewer.cells import nominal_cell
from robolaser.report.viewer.scene import (
    BOX,
    HIT,
    MODEL_COLOURS,
    bar,
    collision_shapes,
    downsampled,
    fixed_shapes,
    moving_shapes,
)
from robolaser.scan.ply import VERTEX

NUMBERS = {"joint_offset.joint_2.offset": 0.02, "laser_drift.laser.angle": 0.01}


@pytest.fixture(scope="module")
def data():
    return dataset()


@pytest.fixture(scope="module")
def models(data):
    calibration = made(data, ["joint_offset:joint_2", "laser_drift"], NUMBERS)
    return nominal_cell(data), CellPoses(calibration.model, calibration.x)


@pytest.fixture(params=[0, 1], ids=["nominal", "calibrated"])
def model(request, models):
    return models[request.param]


def by_name(shapes):
    return {shape.name: shape for shape in shapes}


def test_the_arm_hangs_together_from_base_to_camera(model):
    frames = model.at_pose(3)
    np.testing.assert_allclose(frames.flange, model.flange[3])
    np.testing.assert_allclose(frames.camera, model.camera[3])
    np.testing.assert_allclose(frames.joints[-1] @ model.dataset.robot.end, frames.flange, atol=1e-12)


def test_sliders_at_a_poses_angles_give_that_pose(models):
    model = models[0]
    here, there = model.at(model.dataset.poses.q[5]), model.at_pose(5)
    np.testing.assert_allclose(here.camera, there.camera, atol=1e-12)
    np.testing.assert_allclose(here.corners, there.corners, atol=1e-12)
    np.testing.assert_allclose(here.joints, there.joints, atol=1e-12)
    first = model.at_pose(0)
    moved = apply(here.camera @ inverse(first.camera), first.light)
    np.testing.assert_allclose(here.light, moved, atol=1e-12)


def test_the_light_lies_in_the_sheet_and_comes_from_the_projector(models):
    frames, plane = models[0].at_pose(2), laser_plane(models[0].values)[0, 0]
    light = apply(inverse(frames.camera), frames.light)
    np.testing.assert_allclose(light @ plane[:3], plane[3], atol=1e-12)
    assert abs(light[0, 1:]).max() < 1e-12


def test_the_image_s_corners_are_before_the_camera_and_about_the_light(model):
    frames = model.at_pose(2)
    corners, seen = (apply(inverse(frames.camera), places) for places in (frames.corners, frames.light[1:]))
    assert (corners[:, 2] > 0).all()
    slopes, ends = seen[:, :2] / seen[:, 2:], corners[:, :2] / corners[:, 2:]
    assert (ends.min(axis=0) <= slopes.min(axis=0) + 1e-3).all()
    assert (slopes.max(axis=0) <= ends.max(axis=0) + 1e-3).all()


def test_the_stripe_of_a_pose_is_its_measured_points(model):
    own = model.points[model.dataset.points.pose == 4]
    stripe = model.at_pose(4).light[1:]
    assert {tuple(row) for row in np.round(stripe, 9)} == {tuple(row) for row in np.round(own, 9)}


def test_each_model_has_its_colour_and_the_target_is_where_it_was_given(models):
    for model in models:
        shapes = by_name(fixed_shapes(model, models))
        assert shapes["points/measured"].look["colors"] == MODEL_COLOURS[model.name]
        np.testing.assert_allclose(shapes["target/points"].look["points"], model.dataset.points.xyz, rtol=1e-6)
    sizes = [by_name(fixed_shapes(model, models))["points/measured"].look["point_size"] for model in models]
    assert sizes[0] == sizes[1]


def test_a_target_that_is_not_placed_is_laid_where_it_fits(data):
    T = pose(exp_so3(np.array([0.3, -0.2, 1.0])), np.array([0.4, 0.1, -0.2]))
    seen = nominal_cell(data).points
    moved = replace(data, placed=False, points=replace(data.points, xyz=apply(inverse(T), seen)))
    np.testing.assert_allclose(nominal_cell(moved).target, seen, atol=1e-9)


def test_shapes_are_finite_and_have_names_of_their_own(model):
    shapes = [*moving_shapes(model, model.at_pose(1)), *fixed_shapes(model, (model,))]
    assert len(by_name(shapes)) == len(shapes)
    for shape in shapes:
        for value in shape.look.values():
            assert not isinstance(value, np.ndarray) or np.isfinite(value).all()
    sheet = by_name(shapes)["light/sheet"].look
    assert sheet["faces"].max() == len(sheet["vertices"]) - 1


def test_flange_poses_without_a_robot_are_shown_too(data):
    poses = Poses(data.poses.names, T_base_flange=data.flange())
    model = nominal_cell(replace(data, robot=None, poses=poses))
    shapes = by_name(moving_shapes(model, model.at_pose(0)))
    assert not [name for name in shapes if name.startswith("robot/link")]
    assert {"robot/flange", "sensor/camera", "light/sheet"} <= set(shapes)


def test_other_sensors_show_their_arm(data):
    model = nominal_cell(replace(data, kind="point", parameters={}))
    shown = set(by_name(moving_shapes(model, model.at_pose(0))))
    assert {"robot/foot", "robot/flange", *(f"robot/{joint}" for joint in data.robot.joints)} < shown
    assert all(name.startswith("robot/") for name in shown)
    assert fixed_shapes(model, (model,)) == ()
    assert model.at(data.poses.q[0] + 0.1).camera is None


def test_a_recording_without_points_shows_its_cell(data):
    model = nominal_cell(replace(data, points=Points(np.empty(0, np.int64), ())))
    assert fixed_shapes(model, (model,)) == ()
    light, plane = model.at_pose(0).light, laser_plane(model.values)[0, 0]
    assert len(light) > 10
    np.testing.assert_allclose(apply(inverse(model.camera[0]), light) @ plane[:3], plane[3], atol=1e-12)


def test_a_scanner_without_its_numbers_is_refused(data):
    with pytest.raises(DataError, match="theta"):
        nominal_cell(replace(data, parameters={key: item for key, item in data.parameters.items() if key != "theta"}))


@pytest.mark.parametrize("end", [(0.3, 0.2, 0.1), (0.0, 0.0, 0.5), (0.0, 0.0, -0.5)])
def test_a_bar_leads_from_one_end_to_the_other(end):
    start = np.array([0.1, -0.2, 0.3])
    made = bar("bar", (start, np.array(end)), 0.05, HIT)
    half = np.array([0.0, 0.0, made.look["height"] / 2])
    T = pose(from_quaternion(np.roll(made.look["wxyz"], -1)), made.look["position"])
    np.testing.assert_allclose(apply(T, np.stack([-half, half])), [start, end], atol=1e-12)


@pytest.mark.parametrize("count", [1, 10, 1000, 1001, 2500])
def test_a_cloud_is_thinned_evenly(count):
    cloud = np.zeros(count, VERTEX)
    cloud["x"] = np.arange(count)
    dots = downsampled(cloud, 1000)
    points = dots.look["points"]
    assert min(count, 500) <= len(points) == len(dots.look["colors"]) <= 1000
    assert points[0, 0] == 0
    assert downsampled(cloud[:0]) is None


def test_what_is_hit_is_shown_in_red_where_it_is():
    data = dataset(poses=2)
    robot, q = data.arm
    flange = robot.forward(q[None])[0]
    at = Box("block", tuple(flange[0, :3, 3].tolist()), (0.02, 0.02, 0.02))
    bodies = collision_model(data, Limits(), [at])
    words, shapes = collision_shapes(bodies, 0.01, q[0])
    assert "block overlap by" in words
    assert {shape.look["color"] for shape in shapes} == {HIT}
    block = next(shape for shape in shapes if shape.kind == "box" and max(shape.look["dimensions"]) < 0.03)
    np.testing.assert_allclose(block.look["position"], flange[0, :3, 3], atol=1e-12)
    words, shapes = collision_shapes(bodies, 0.01, q[1])
    assert words == "nothing is hit"
    assert [shape.look["color"] for shape in shapes] == [BOX]
