"""A X = Z B: found wherever X and Z lie, held where they are known, and told from data that cannot say."""

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from robolaser.geometry.hand_eye import LEAST_TURN, robot_world_hand_eye, turn_about_second_axis
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
    given = {"X": X} if known == "X" else {"Z": Z}
    found_X, found_Z = robot_world_hand_eye(A, inverse(Z) @ A @ X, **given)
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
