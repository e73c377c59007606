"""What yields under weight besides gears: bases, brackets, links."""

from dataclasses import replace

import numpy as np
import pinocchio
import pytest

from robolaser.arrays import Array
from robolaser.data.dataset import Dataset, Points, Poses
from robolaser.geometry.rigid_motion import exp_so3
from robolaser.model.effects.base_compliance import BaseCompliance, horizontal_axes
from robolaser.model.effects.hand_eye_sag import HandEyeSag
from robolaser.model.effects.link_compliance import LinkCompliance
from robolaser.model.effects.run import Run
from robolaser.robot.by_name import find_robot

ONE, NONE = np.ones(1), np.zeros(1)


@pytest.fixture
def dataset() -> Dataset:
    """The UR5 in eight postures."""
    q = np.random.default_rng(1).uniform(-1.5, 1.5, (8, 6))
    poses = Poses(tuple(map(str, range(8))), time_s=np.arange(8.0), q=q)
    return Dataset("arm", poses, Points(np.empty(0, dtype=np.int64), ()), kind="point", robot=find_robot("ur5"))


def test_what_the_joints_carry_agrees_with_their_gravity_torques(dataset: Dataset) -> None:
    robot, q = dataset.arm
    mass, centre = robot.carried(q)
    frames = robot.joint_frames(q[None])[0]
    axes = np.einsum("nkab,kb->nka", frames[..., :3, :3], robot.axes)
    moment = np.cross(centre - frames[..., :3, 3], mass[:, None] * np.array(robot.gravity))
    np.testing.assert_allclose(-(moment * axes).sum(axis=-1), robot.gravity_torques(q), atol=1e-9)


def test_the_overturning_moment_is_that_of_the_whole_arms_weight_and_of_its_payload(dataset: Dataset) -> None:
    robot, q = dataset.arm
    model = pinocchio.buildModelFromXML(robot.urdf)
    data = model.createData()
    centre = np.array([pinocchio.centerOfMass(model, data, row).copy() for row in q])
    arm = np.cross(centre, data.mass[0] * np.array(robot.gravity))
    np.testing.assert_allclose(Run(dataset).loads.overturning_moment, arm, atol=1e-9)
    loaded = Run(replace(dataset, poses=replace(dataset.poses, payload_kg=np.full(8, 2.0))))
    tip = np.cross(dataset.flange()[:, :3, 3], 2.0 * np.array(robot.gravity))
    np.testing.assert_allclose(loaded.loads.overturning_moment, arm + tip, atol=1e-9)


def test_a_yielding_base_lets_the_arm_sink_on_the_side_to_which_it_reaches(dataset: Dataset) -> None:
    run = Run(dataset)
    T = dataset.flange()
    moved = BaseCompliance("base", 1e-5 * ONE, NONE, NONE, NONE).apply(T[None], run)[0]
    np.testing.assert_allclose(
        moved[:, :3, :3] @ np.swapaxes(T[:, :3, :3], 1, 2), exp_so3(1e-5 * run.loads.overturning_moment)
    )
    _, first_moment = run.loads.carried
    side = (first_moment[:, 0, :2] * T[:, :2, 3]).sum(axis=1)
    assert (np.sign(moved[:, 2, 3] - T[:, 2, 3]) == -np.sign(side)).all()


def test_a_base_may_be_stiff_about_one_axis(dataset: Dataset) -> None:
    run, T = Run(dataset), dataset.flange()[None]
    moved = BaseCompliance("base", 1e-5 * ONE, -ONE, NONE, NONE).apply(T, run)[0]
    about_y = 2e-5 * run.loads.overturning_moment * [0, 1, 0]
    np.testing.assert_allclose(moved[:, :3, :3], exp_so3(about_y) @ T[0, :, :3, :3], atol=1e-15)


def test_a_pedestal_turns_about_its_foot(dataset: Dataset) -> None:
    run, T = Run(dataset), dataset.flange()[None]
    base, tilted = (BaseCompliance("base", 1e-5 * ONE, NONE, NONE, depth).apply(T, run) for depth in (NONE, 0.5 * ONE))
    np.testing.assert_allclose(tilted[..., :3, :3], base[..., :3, :3], atol=1e-15)
    lifted = np.cross(1e-5 * run.loads.overturning_moment, [0.0, 0.0, 0.5])  # to first order
    np.testing.assert_allclose((tilted - base)[0, :, :3, 3], lifted, atol=1e-6)


@pytest.mark.parametrize("down", [[0, 0, -9.81], [0, -9.81, 0], [-9.81, 0, 0], [3.0, 4.0, 5.0]])
def test_horizontal_axes_are_two_across_gravity(down: list[float]) -> None:
    axes = horizontal_axes(np.array(down))
    np.testing.assert_allclose(axes @ axes.T, np.eye(2), atol=1e-15)
    np.testing.assert_allclose(axes @ down, 0, atol=1e-14)
    np.testing.assert_array_equal(horizontal_axes(np.array([0, 0, -9.81])), np.eye(3)[:2])


def test_a_bracket_sinks_downwards_and_bows_to_the_moment_of_what_hangs_on_it(dataset: Dataset) -> None:
    run, T = Run(dataset), dataset.flange()
    mount = np.eye(4)
    mount[:3, 3] = 0.1, 0.0, 0.05
    sunk = T @ HandEyeSag("hand_eye", 1e-3 * ONE, *[NONE] * 6).apply(mount[None, None], run)[0]
    np.testing.assert_allclose(sunk[:, :3, 3] - (T @ mount)[:, :3, 3], np.tile([0, 0, -1e-3], (8, 1)), atol=1e-15)
    bowed = T @ HandEyeSag("hand_eye", NONE, 0.01 * ONE, *[NONE] * 5).apply(mount[None, None], run)[0]
    turn = np.cross(0.01 * T[:, :3, 0], [0, 0, -1])
    np.testing.assert_allclose(bowed[:, :3, :3], exp_so3(turn) @ T[:, :3, :3], atol=1e-15)
    np.testing.assert_allclose(bowed[:, :3, 3], (T @ mount)[:, :3, 3], atol=1e-15)


def test_a_bracket_softer_about_one_axis_turns_more_about_it(dataset: Dataset) -> None:
    run, soft, lever = Run(dataset), np.array([2.0, 1.0, 0.5]), np.array([0.004, -0.003, 0.002])
    M = soft[:, None] * np.cross(lever, np.eye(3)).T  # soft (lever × ĝ), zero on its diagonal
    pairs = ((2, 1), (0, 2), (1, 0))
    numbers = [np.array([(M[i, j] + sign * M[j, i]) / 2]) for sign in (-1, 1) for i, j in pairs]
    turned = HandEyeSag("hand_eye", NONE, *numbers).apply(np.eye(4)[None, None], run)[0]
    np.testing.assert_allclose(turned[:, :3, :3], exp_so3(run.gravity_in_flange @ M.T), atol=1e-15)


def test_without_a_robot_down_is_down() -> None:
    T = np.tile(np.eye(4), (3, 1, 1))
    T[:, :3, :3] = exp_so3(np.random.default_rng(2).normal(size=(3, 3)))
    poses = Poses(("0", "1", "2"), T_base_flange=T)
    run = Run(Dataset("cell", poses, Points(np.empty(0, dtype=np.int64), ()), kind="stripe"))
    np.testing.assert_allclose(
        np.einsum("nab,nb->na", T[:, :3, :3], run.gravity_in_flange), [[0, 0, -1]] * 3, atol=1e-15
    )


@pytest.mark.parametrize("joint", [1, 2, 4])
def test_the_moment_at_a_joint_about_its_axis_is_what_the_joint_bears(dataset: Dataset, joint: int) -> None:
    run = Run(dataset)
    moment = run.loads.of_link(dataset.robot.joints[joint]).moment(np.zeros((1, 1, 1)), np.zeros((1, 1, 1)))[0]
    np.testing.assert_allclose(-moment @ dataset.robot.axes[joint], run.loads.gravity_torques[:, joint], atol=1e-9)


def test_the_moment_at_the_joint_before_is_what_that_joint_bears(dataset: Dataset) -> None:
    run, robot = Run(dataset), dataset.robot
    placement = robot.placements[2, :3, :3]
    moment = run.loads.of_link(robot.joints[2]).moment(np.ones((1, 1, 1)), np.zeros((1, 1, 1)))[0] @ placement.T
    np.testing.assert_allclose(-moment @ robot.axes[1], run.loads.gravity_torques[:, 1], atol=1e-9)


def turned(dataset: Dataset, joint: int, bending: float, twist: float, axial: float) -> Array:
    """The turn of a joint's placement under the load, hinged at the joint, (n, 3) [rad]."""
    robot, size = dataset.arm[0], (bending * ONE, twist * ONE, axial * ONE, ONE, NONE)
    bent = LinkCompliance(robot.joints[joint], *size).apply(robot.placements[None, None], Run(dataset))[0, :, joint]
    R = robot.placements[joint, :3, :3].T @ bent[:, :3, :3]
    return np.stack([R[:, 2, 1] - R[:, 1, 2], R[:, 0, 2] - R[:, 2, 0], R[:, 1, 0] - R[:, 0, 1]], axis=-1) / 2


def test_a_link_that_yields_alike_in_all_directions_turns_with_the_moment(dataset: Dataset) -> None:
    moment = Run(dataset).loads.of_link(dataset.robot.joints[2]).moment(np.zeros((1, 1, 1)), np.zeros((1, 1, 1)))[0]
    np.testing.assert_allclose(turned(dataset, 2, 1e-6, 1e-6, 1.0), 1e-6 * moment, atol=1e-12)


def test_a_tilting_bearing_does_not_turn_the_joint_about_its_axis(dataset: Dataset) -> None:
    turn = turned(dataset, 4, 1e-6, 2e-6, 0.0)
    assert np.abs(turn).max() > 1e-7
    np.testing.assert_allclose(turn @ dataset.robot.axes[4], 0, atol=1e-12)


def test_a_link_that_only_twists_turns_about_its_direction(dataset: Dataset) -> None:
    placement = dataset.robot.placements[2]
    along = placement[:3, :3].T @ placement[:3, 3]
    axis = dataset.robot.axes[2]
    along -= axis * (along @ axis)
    np.testing.assert_allclose(np.cross(turned(dataset, 2, 0.0, 1e-6, 1.0), along), 0, atol=1e-12)


def test_a_link_hinged_at_the_joint_before_leaves_that_joint_where_it_is(dataset: Dataset) -> None:
    run, robot = Run(dataset), dataset.arm[0]
    bent = LinkCompliance(robot.joints[2], ONE * 1e-4, ONE * 1e-4, ONE, NONE, NONE).apply(
        robot.placements[None, None], run
    )
    straight = np.linalg.norm(robot.placements[2, :3, 3])
    np.testing.assert_allclose(np.linalg.norm(bent[0, :, 2, :3, 3], axis=-1), straight, atol=1e-12)
    assert np.ptp(bent[0, :, 2, :3, 3], axis=0).max() > 1e-4


def test_what_is_before_the_first_joint_is_the_base_and_no_link(dataset: Dataset) -> None:
    assert LinkCompliance.sites(dataset.robot) == dataset.robot.joints[1:]


def test_a_payload_that_nobody_stated_bends_a_link_as_one_stated_does(dataset: Dataset) -> None:
    joint, sizes = dataset.robot.joints[2], (1e-5 * ONE, 1e-5 * ONE, ONE, 0.5 * ONE)
    loaded = Run(replace(dataset, poses=replace(dataset.poses, payload_kg=np.full(8, 2.0))))
    placements = dataset.robot.placements[None, None]
    stated = LinkCompliance(joint, *sizes, NONE).apply(placements, loaded)
    unstated = LinkCompliance(joint, *sizes, 2.0 * ONE).apply(placements, Run(dataset))
    np.testing.assert_allclose(unstated, stated, atol=1e-15)
