"""What a sensor would measure from other poses of the flange."""

from dataclasses import replace

import numpy as np
import pytest

from robolaser.data.dataset import Poses
from robolaser.data.stated_noise import Noise
from robolaser.diagnosis import examine
from robolaser.geometry.rigid_motion import apply, inverse, pose
from robolaser.model.effects.encoder_eccentricity import EncoderEccentricity
from robolaser.model.effects.encoder_scale import EncoderScale
from robolaser.model.forward_model import Model
from robolaser.model.sensors.placements import motion
from robolaser.robot.by_name import find_robot
from robolaser.robot.postures import random_configurations
from robolaser.simulation import CellOptions, simulate

ROBOT = find_robot("ur5")


@pytest.mark.parametrize("placed", [True, False])
def test_a_stripe_on_the_target_leaves_no_residual_from_wherever_it_is_seen(placed: bool) -> None:
    made = simulate(ROBOT, poses=12, points=8, options=CellOptions(placed=placed), seed=2)
    values = {name: np.array([value]) for name, value in made.truth.items()}
    q = made.dataset.poses.q + np.random.default_rng(0).normal(0.0, 0.02, (12, 6))
    points, good = Model(made.dataset).blocks.sensor.new_poses.seen_from(values, ROBOT.forward(q[None])[0])
    assert good.any()
    there = Model(replace(made.dataset, poses=Poses(made.dataset.poses.names, q=q), points=points))
    left = np.abs(
        there.blocks.sensor.residuals({**values, "k": np.zeros(1)}, there.flange(values), there.perturb(values))
    )
    assert left.reshape(12, -1)[good].max() < 1e-9


def test_a_tracker_sees_each_reflector_from_every_pose() -> None:
    made = simulate(ROBOT, kind="point", poses=5, points=4, seed=2)
    q = random_configurations(ROBOT, 3, np.random.default_rng(0))
    points, good = Model(made.dataset).blocks.sensor.new_poses.seen_from({}, ROBOT.forward(q[None])[0])
    assert points.names == ("0", "1", "2", "3") * 3
    np.testing.assert_array_equal(points.pose, np.repeat([0, 1, 2], 4))
    assert good.all()


def test_an_arm_in_a_socket_goes_nowhere_else() -> None:
    sensor = Model(simulate(ROBOT, kind="socket", poses=6, points=3).dataset).blocks.sensor
    assert sensor.new_poses.seen_from({}, np.eye(4)[None]) is None


@pytest.mark.parametrize("mount", ["flange", "base"])
def test_profiles_of_balls_that_poses_aim_at_leave_no_residual(mount: str) -> None:
    made = simulate(ROBOT, kind="profile", poses=12, points=2, options=CellOptions(mount=mount), seed=2)
    sensor = Model(made.dataset).blocks.sensor
    values = {name: np.array([value]) for name, value in made.truth.items()}
    T_base_flange = made.dataset.flange()
    tools, goals = sensor.new_poses.aims(values, T_base_flange)
    np.testing.assert_allclose(apply(T_base_flange, tools), goals, atol=1e-12)
    points, good = sensor.new_poses.seen_from(values, T_base_flange)
    assert good.mean() > 0.5
    left = np.abs(Model(replace(made.dataset, points=points)).residuals_at(values)).reshape(12, -1)
    assert left[good].max() < 1e-9


def test_next_poses_of_a_profile_sensor_see_a_ball_within_the_limits() -> None:
    sizes = {"encoder_scale:joint_2": 1e-4}
    robot = find_robot("scorbot_er7")
    made = simulate(robot, kind="profile", poses=30, points=2, noise=Noise(point_m=2e-5), effects=sizes, seed=1)
    found = examine(made.dataset, [EncoderScale, EncoderEccentricity], seed=0)
    q = np.array([[pose[joint] for joint in robot.joints] for pose in found.next_poses])
    assert len(q)
    assert ((q >= robot.lower) & (q <= robot.upper)).all()
    values = {name: np.array([value]) for name, value in made.truth.items()}
    assert Model(made.dataset).blocks.sensor.new_poses.seen_from(values, robot.forward(q[None])[0])[1].all()


@pytest.mark.parametrize("mount", ["flange", "base"])
def test_a_camera_sees_no_board_from_behind(mount: str) -> None:
    options = CellOptions(mount=mount, placed=False)
    made = simulate(ROBOT, kind="camera", poses=8, points=12, options=options, seed=2)
    sensor = Model(made.dataset).blocks.sensor
    values = {name: np.array([value]) for name, value in made.truth.items()}
    T_base_flange = made.dataset.flange()
    assert sensor.new_poses.seen_from(values, T_base_flange)[1].all()
    carried, standing = (motion(values, name)[0] for name in ("hand_eye", "target"))
    if mount == "base":
        carried, standing = standing, carried
    xyz = made.dataset.points.xyz
    turn = pose(np.diag([-1.0, 1.0, -1.0]), xyz.mean(axis=0) * (2.0, 0.0, 2.0))  # about the board's middle
    if mount == "flange":
        behind = standing @ turn @ inverse(standing) @ T_base_flange
    else:
        behind = T_base_flange @ carried @ turn @ inverse(carried)
    assert not sensor.new_poses.seen_from(values, behind)[1].any()
