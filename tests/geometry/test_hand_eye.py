"""A X = Z B: found wherever X and Z lie, held where they are known, and told from data that cannot say."""

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from robolaser.errors import EstimationError
from robolaser.geometry.hand_eye import LEAST_TURN, hand_eye_by_travel, robot_world_hand_eye, turn_about_second_axis
from robolaser.geometry.rigid_motion import exp_so3, inverse, pose


def motions(count: int, rng: np.random.Generator) -> np.ndarray:
    return pose(Rotation.random(count, random_state=rng).as_matrix(), rng.normal(size=(count, 3)))


@pytest.mark.parametrize("seed", range(5))
def test_without_noise_both_are_exact_wherever_they_lie(seed: int) -> None:
    rng = np.random.default_rng(seed)
    A, X, Z = motions(6, rng), motions(1, rng), motions(1, rng)[0]
    found_X, found_Z = robot_world_hand_eye(A, inverse(Z) @ A @ X)
    np.testing.assert_allclose(found_X, X, atol=1e-9)
    np.testing.assert_allclose(found_Z, Z, atol=1e-9)


def test_several_bodies_share_one_world() -> None:
    rng = np.random.default_rng(1)
    A, X, Z, of = motions(12, rng), motions(3, rng), motions(1, rng)[0], np.arange(12) % 3
    found_X, found_Z = robot_world_hand_eye(A, inverse(Z) @ A @ X[of], of)
    np.testing.assert_allclose(found_X, X, atol=1e-9)
    np.testing.assert_allclose(found_Z, Z, atol=1e-9)


@pytest.mark.parametrize("known", ["X", "Z"])
def test_what_is_known_is_held(known: str) -> None:
    rng = np.random.default_rng(2)
    A, X, Z = motions(5, rng), motions(1, rng), motions(1, rng)[0]
    found_X, found_Z = robot_world_hand_eye(A, inverse(Z) @ A @ X, **{"X": X} if known == "X" else {"Z": Z})
    np.testing.assert_allclose(found_X, X, atol=1e-9)
    np.testing.assert_allclose(found_Z, Z, atol=1e-9)


def test_noise_moves_the_result_no_more_than_itself() -> None:
    rng = np.random.default_rng(3)
    A, X, Z = motions(30, rng), motions(1, rng), motions(1, rng)[0]
    B = inverse(Z) @ A @ X
    noisy = pose(B[:, :3, :3] @ exp_so3(1e-3 * rng.normal(size=(30, 3))), B[:, :3, 3] + 1e-3 * rng.normal(size=(30, 3)))
    found_X, found_Z = robot_world_hand_eye(A, noisy)
    assert np.abs(found_X - X).max() < 3e-3
    assert np.abs(found_Z - Z).max() < 3e-3


def test_turns_about_one_axis_are_told_from_turns_about_two() -> None:
    rng = np.random.default_rng(4)
    one = exp_so3(np.outer(rng.uniform(-1, 1, 10), [0.0, 0.6, 0.8]))
    two = exp_so3(rng.uniform(-0.3, 0.3, (10, 3)))
    assert turn_about_second_axis(one) < 1e-6
    assert turn_about_second_axis(two) > 2 * LEAST_TURN


@pytest.mark.parametrize("turn", [0.0, 1.0])
def test_travel_tells_what_turns_do_not(turn: float) -> None:
    rng = np.random.default_rng(5)
    X, Z, first = motions(1, rng)[0], motions(1, rng)[0], motions(1, rng)[0, :3, :3]
    axis = np.array([0.0, 0.6, 0.8])
    A = pose(exp_so3(np.outer(rng.uniform(-turn, turn, 10), axis)) @ first, rng.normal(size=(10, 3)))
    found_X, found_Z = hand_eye_by_travel(A, inverse(Z) @ A @ X)
    np.testing.assert_allclose(found_X[:3, :3], X[:3, :3], atol=1e-9)
    np.testing.assert_allclose(found_Z[:3, :3], Z[:3, :3], atol=1e-9)
    np.testing.assert_allclose(A @ found_X, found_Z @ inverse(Z) @ A @ X, atol=1e-9)
    along = first.T @ axis
    untold = found_X[:3, 3] - (X[:3, 3] - (along @ X[:3, 3]) * along if turn else np.zeros(3))
    np.testing.assert_allclose(untold, 0.0, atol=1e-9)


def test_travel_along_one_line_without_turns_tells_nothing() -> None:
    A = np.repeat(np.eye(4)[None], 5, axis=0)
    A[:, 0, 3] = np.arange(5.0)
    with pytest.raises(EstimationError, match="two directions"):
        hand_eye_by_travel(A, A)
