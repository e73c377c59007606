"""What other programs read of a calibration must say what the model says."""

import shlex
from dataclasses import replace

import cv2
import numpy as np
import pinocchio
import pytest
import yaml
from calibrated import KINDS, arm, bent, point, socket, stripe
from cells import project

from robolaser.calibration.calibrate import calibrate
from robolaser.export.ros import camera_yaml, easy_handeye2, plumb_bob, static_transform
from robolaser.export.urdf import corrected_urdf, robot_urdf
from robolaser.geometry.camera import metric, rays, undistort
from robolaser.geometry.rigid_motion import apply, from_quaternion, inverse, pose
from robolaser.model.forward_model import Model
from robolaser.model.sensors import scanner_geometry
from robolaser.model.sensors.placements import motion
from robolaser.robot.by_name import find_robot
from robolaser.robot.kinematics import Robot
from robolaser.simulation import CellOptions, simulate

BENT = ("joint_offset", "link_geometry", "laser_roll")


def frames(text, q=None):
    """Every frame of a URDF in that of its root, by Pinocchio."""
    model = pinocchio.buildModelFromXML(text)
    data = model.createData()
    pinocchio.framesForwardKinematics(model, data, pinocchio.neutral(model) if q is None else q)
    return {frame.name: data.oMf[i].homogeneous for i, frame in enumerate(model.frames)}


def values_of(calibration):
    return calibration.model.parameters.values(calibration.x[None])


def mount(calibration):
    values = values_of(calibration)
    return calibration.model.blocks.sensor.in_cell(values, calibration.model.perturb(values)).mount[0, 0]


def cameras():
    return [stripe(axis="u"), stripe(axis="v"), stripe(robot=arm(), effects=("laser_roll",))]


@pytest.mark.parametrize("kind", KINDS)
def test_pinocchio_reads_the_robot(kind):
    assert "flange" in frames(robot_urdf(KINDS[kind]()))


@pytest.mark.parametrize("calibration", cameras(), ids=["u", "v", "rolled"])
def test_the_camera_frame_is_where_the_model_has_it(calibration):
    at = frames(robot_urdf(calibration))
    np.testing.assert_allclose(inverse(at["flange"]) @ at["scanner_camera"], mount(calibration), atol=1e-9)


def seen_in_camera(calibration):
    dataset, values = calibration.model.dataset, calibration.values
    pixel, perturb = dataset.points.pixel[None], calibration.model.perturb(values)
    return scanner_geometry.in_camera(pixel, values, perturb, dataset.stripe_axis)[0]


@pytest.mark.parametrize("calibration", cameras(), ids=["u", "v", "rolled"])
def test_the_optical_frame_sees_u_along_x_and_v_along_y(calibration):
    at = frames(robot_urdf(calibration))
    points = calibration.model.dataset.points
    values = values_of(calibration)
    seen = seen_in_camera(calibration)
    x, y, z = apply(inverse(at["scanner_camera_optical"]) @ at["scanner_camera"], seen).T
    flat = undistort(metric(points.pixel[None], values), values["k"])[0]
    np.testing.assert_allclose(np.stack([x / z, y / z], axis=-1), flat / values["f"], atol=1e-9)


@pytest.mark.parametrize("calibration", cameras(), ids=["u", "v", "rolled"])
def test_all_points_lie_in_the_sheet_of_the_laser_frame(calibration):
    at = frames(robot_urdf(calibration))
    seen = seen_in_camera(calibration)
    T_camera_laser = inverse(at["scanner_camera"]) @ at["scanner_laser"]
    in_sheet = apply(inverse(T_camera_laser), seen)
    np.testing.assert_allclose(in_sheet[:, 0], 0.0, atol=1e-9)
    assert (in_sheet[:, 2] > 0).all()
    np.testing.assert_allclose(T_camera_laser[1:3, 3], 0.0, atol=1e-9)


def test_without_roll_the_laser_sits_at_the_baseline():
    calibration = stripe()
    at = frames(robot_urdf(calibration))
    T_camera_laser = inverse(at["scanner_camera"]) @ at["scanner_laser"]
    assert T_camera_laser[0, 3] == pytest.approx(calibration.value("b"), abs=1e-9)


def test_tools_sit_where_the_model_has_them():
    calibration = point()
    at = frames(robot_urdf(calibration))
    for name in ("left", "right"):
        place = [calibration.value(f"tool.{name}.{part}") for part in "xyz"]
        np.testing.assert_allclose((inverse(at["flange"]) @ at[f"tool_{name}"])[:3, 3], place, atol=1e-9)
    assert "tool_ball" in frames(robot_urdf(socket()))


def test_a_robot_that_has_such_frames_already_keeps_them():
    again = stripe(robot=Robot.from_urdf(robot_urdf(stripe(robot=arm())), flange="flange"))
    at = frames(robot_urdf(again))
    np.testing.assert_allclose(inverse(at["flange"]) @ at["scanner_camera_2"], mount(again), atol=1e-9)


def test_the_corrected_robot_moves_as_the_bent_chain():
    calibration = stripe(robot=arm(), effects=BENT)
    wanted = calibration.model.flange(values_of(calibration))[0]
    text, q = corrected_urdf(calibration), calibration.model.dataset.poses.q
    for T, angles in zip(wanted, q, strict=True):
        np.testing.assert_allclose(frames(text, angles)["flange"], T, atol=1e-9)
    exported = Robot.from_urdf(text, flange="flange").forward(q[None])[0]
    np.testing.assert_allclose(exported, wanted, atol=1e-9)
    np.testing.assert_allclose(calibration.robot.forward(q[None])[0], exported, rtol=0, atol=1e-12)
    assert np.abs(wanted - arm().forward(q[None])[0]).max() > 1e-4


def test_there_is_no_corrected_robot_without_effects_that_a_urdf_can_say():
    assert corrected_urdf(stripe(robot=arm(), effects=("laser_roll",))) is None
    assert corrected_urdf(stripe()) is None


@pytest.mark.parametrize("k", [0.0, 600.0, 5000.0])
@pytest.mark.parametrize("axis", ["u", "v"])
def test_opencv_projects_as_the_calibrated_lens_does(axis, k):
    calibration = stripe(axis=axis, k=k)
    values = values_of(calibration)
    camera = calibration.model.blocks.sensor.in_cell(values, calibration.model.perturb(values)).camera
    distortion, error_px = plumb_bob(camera, (640, 480), decentred=False)
    K = camera.K
    pixel = np.stack(np.meshgrid(np.linspace(0, 639, 23), np.linspace(0, 479, 19)), axis=-1).reshape(1, -1, 2)
    flat = undistort(metric(pixel, values), values["k"])
    ray = rays(flat, values["f"], axis) * 50
    back = project(ray, values, axis)[0]
    np.testing.assert_allclose(back, pixel[0], atol=1e-6)
    at = frames(robot_urdf(calibration))
    optical = apply(inverse(at["scanner_camera_optical"]) @ at["scanner_camera"], ray[0])
    projected = cv2.projectPoints(optical, np.zeros(3), np.zeros(3), K, distortion)[0][:, 0]
    assert np.linalg.norm(projected - back, axis=-1).max() <= error_px + 1e-6
    assert error_px < 0.05


def test_the_camera_file_is_what_ros_reads():
    lines = camera_yaml(stripe(name='two\nlines: "and" \U0001f600')).splitlines()
    assert lines[0].startswith("#")
    assert "image_width: 640" in lines
    assert "image_height: 480" in lines
    assert "distortion_model: plumb_bob" in lines
    assert sum(line.startswith("camera_name:") for line in lines) == 1
    counts = {"camera_matrix": 9, "distortion_coefficients": 5, "rectification_matrix": 9, "projection_matrix": 12}
    for name, count in counts.items():
        i = lines.index(f"{name}:")
        rows, columns = (int(lines[i + n].split(":")[1]) for n in (1, 2))
        data = lines[i + 3].partition("[")[2].rstrip("]").split(",")
        assert rows * columns == count == len([float(number) for number in data])


def test_a_tracker_has_no_camera():
    assert camera_yaml(point()) is None


@pytest.fixture(scope="module", params=["flange", "base"])
def camera(request):
    made = simulate(
        find_robot("ur5"), kind="camera", poses=8, points=12,
        options=CellOptions(mount=request.param, placed=False), seed=3,
    )  # fmt: skip
    return calibrate(made.dataset)


def test_a_cameras_frame_in_the_urdf_is_where_the_model_has_it(camera):
    T = motion(values_of(camera), "hand_eye")[0]
    at = frames(robot_urdf(camera))
    rides = camera.model.dataset.options.mount == "flange"
    carrier = camera.model.dataset.robot.flange if rides else "world"
    np.testing.assert_allclose(inverse(at[carrier]) @ at["camera_optical"], T, atol=1e-9)


def test_camera_info_has_a_cameras_own_lens(camera):
    info = yaml.safe_load(camera_yaml(camera))
    names = ("k1", "k2", "p1", "p2", "k3")
    assert info["distortion_coefficients"]["data"] == pytest.approx([camera.value(name) for name in names], rel=1e-9)
    assert info["camera_matrix"]["data"][::4] == pytest.approx([camera.value("fx"), camera.value("fy"), 1.0])


@pytest.mark.parametrize("kind", ["stripe", "camera", "stripe+camera"])
def test_camera_info_of_a_lens_that_breathes_is_that_at_the_mean_distance(kind):
    dataset = simulate(find_robot("ur5"), kind=kind, poses=8, seed=3).dataset
    breathing = bent(dataset, {"focus_breathing:camera.breathing": 0.02})
    assert camera_yaml(breathing) == camera_yaml(bent(dataset, {}))


def test_a_published_transform_and_easy_handeye2s_file_are_the_hand_eye(camera):
    T = motion(values_of(camera), "hand_eye")[0]
    words = static_transform(camera).split()
    told = dict(zip(words[4::2], words[5::2], strict=True))
    numbers = [float(told[f"--{name}"]) for name in ("x", "y", "z", "qx", "qy", "qz", "qw")]
    np.testing.assert_allclose(pose(from_quaternion(np.array(numbers[3:])), np.array(numbers[:3])), T, atol=1e-8)
    file = yaml.safe_load(easy_handeye2(camera))
    rides = camera.model.dataset.options.mount == "flange"
    assert file["parameters"]["calibration_type"] == ("eye_in_hand" if rides else "eye_on_base")
    assert told["--frame-id"] == file["parameters"]["robot_effector_frame" if rides else "robot_base_frame"]
    assert list(file["transform"]["translation"].values()) == pytest.approx(numbers[:3])
    assert list(file["transform"]["rotation"].values()) == pytest.approx(numbers[3:])


def test_ros_is_told_where_a_scanner_is_and_nothing_of_reflectors():
    published = static_transform(stripe())
    assert [line.removesuffix(" &").split()[-1] for line in published.splitlines()] == [
        "scanner_camera", "scanner_camera_optical", "scanner_laser"
    ]  # fmt: skip
    assert static_transform(point()) is None


def test_names_of_frames_are_text_to_a_shell_and_to_yaml_whatever_they_are(camera):
    data = camera.model.dataset
    names = {"world": "$(id) #1", "tool0": "yes: 'tool'"}
    text = data.robot.urdf
    for name, odd in names.items():
        text = text.replace(f'"{name}"', f'"{odd}"')
    robot = Robot.from_urdf(text, flange=names["tool0"], joints=data.robot.joints)
    odd = replace(camera, model=Model(replace(data, robot=robot, name="cell \U0001f916")))
    words = shlex.split(static_transform(odd))
    link = words[words.index("--frame-id") + 1]
    assert link == (robot.flange if data.options.mount == "flange" else names["world"])
    file = yaml.safe_load(easy_handeye2(odd))["parameters"]
    assert file["robot_effector_frame"] == names["tool0"]
    assert file["robot_base_frame"] == names["world"]
    assert file["name"] == yaml.safe_load(camera_yaml(odd))["camera_name"] == "cell \U0001f916"


def test_without_an_arm_there_is_no_corrected_robot_and_without_effects_it_is_the_nominal_one():
    assert stripe().robot is None
    plain = stripe(robot=arm())
    assert plain.robot is plain.model.dataset.robot
