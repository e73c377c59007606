"""Hand-eye in closed form: exact without noise, near with it, and told apart from what poses leave open."""

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from robolaser.geometry.hand_eye import robot_world_hand_eye, turns_about_axes
from robolaser.geometry.rigid_motion import exp_so3, inverse, pose

RNG = np.random.default_rng(3)


def motions(*shape: int) -> np.ndarray:
    R = Rotation.random(int(np.prod(shape)), random_state=RNG).as_matrix().reshape(*shape, 3, 3)
    return pose(R, RNG.normal(size=(*shape, 3)))


@pytest.mark.parametrize("tools", [1, 3])
def test_without_noise_any_hand_eye_is_found_with_nothing_given(tools: int) -> None:
    T_world_base, T_flange_tool = motions(8), motions(8, tools)
    T_base_flange, tool = motions(1, 12), np.arange(12) % tools
    T_world_tool = T_world_base[:, None] @ T_base_flange @ T_flange_tool[:, tool]
    Z, X = robot_world_hand_eye(T_base_flange, T_world_tool, tool)
    np.testing.assert_allclose(Z, T_world_base, atol=1e-11)
    np.testing.assert_allclose(X, T_flange_tool, atol=1e-11)


def test_a_camera_on_the_flange_is_the_same_problem_turned_round() -> None:
    T_base_target, T_flange_camera, T_base_flange = motions(1), motions(1), motions(1, 9)
    T_camera_target = inverse(T_base_flange @ T_flange_camera[:, None]) @ T_base_target[:, None]
    Z, X = robot_world_hand_eye(T_base_flange, inverse(T_camera_target), np.zeros(9, dtype=np.int64))
    np.testing.assert_allclose(inverse(Z), T_base_target, atol=1e-11)
    np.testing.assert_allclose(X[:, 0], T_flange_camera, atol=1e-11)


def test_poses_that_hardly_turn_and_noise_leave_it_near() -> None:
    T_world_base, T_flange_tool = motions(1), motions(1)
    nearby = exp_so3(0.3 * RNG.normal(size=(30, 3)))
    T_base_flange = pose(nearby, 0.3 * RNG.normal(size=(30, 3)))[None]
    shaken = pose(exp_so3(5e-3 * RNG.normal(size=(30, 3))), 1e-3 * RNG.normal(size=(30, 3)))
    T_world_tool = T_world_base @ T_base_flange @ T_flange_tool @ shaken
    Z, X = robot_world_hand_eye(T_base_flange, T_world_tool, np.zeros(30, dtype=np.int64))
    np.testing.assert_allclose(Z, T_world_base, atol=0.03)
    np.testing.assert_allclose(X[:, 0], T_flange_tool, atol=0.03)


def test_turns_about_two_axes_are_told_from_turns_about_one_and_from_none() -> None:
    about_z = exp_so3(np.outer(RNG.uniform(-1.0, 1.0, 40), [0.0, 0.0, 1.0]))
    anyhow = motions(1)[0, :3, :3]
    np.testing.assert_allclose(turns_about_axes(np.tile(anyhow, (5, 1, 1))), 0.0, atol=1e-12)
    first, second, third = turns_about_axes(anyhow @ about_z)
    assert first == pytest.approx(1.0 / np.sqrt(3.0), rel=0.3)
    assert max(second, third) < 1e-9
    assert turns_about_axes(exp_so3(0.2 * RNG.normal(size=(500, 3)))) == pytest.approx(np.full(3, 0.2), rel=0.15)
