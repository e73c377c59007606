"""Rigid motions: laws, and agreement with SciPy."""

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from robolaser.duals import Dual
from robolaser.geometry.rigid_motion import (
    apply,
    exp_so3,
    from_angles,
    from_quaternion,
    inverse,
    log_so3,
    nearest_rotation,
    pose,
    rigid_fit,
    skew,
    to_angles,
    to_quaternion,
)

SEED = 11
RNG = np.random.default_rng(SEED)


@pytest.fixture(autouse=True)
def same_draws_in_any_order(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setitem(globals(), "RNG", np.random.default_rng(SEED))


def motions(*shape: int) -> np.ndarray:
    return pose(
        Rotation.random(int(np.prod(shape)), random_state=5).as_matrix().reshape(*shape, 3, 3),
        RNG.normal(size=(*shape, 3)),
    )


def test_a_motion_and_its_inverse_undo_each_other() -> None:
    T = motions(4, 5)
    np.testing.assert_allclose(T @ inverse(T), np.broadcast_to(np.eye(4), T.shape), atol=1e-14)


def test_frames_chain() -> None:
    T_a_b, T_b_c, P = motions(6), motions(6), RNG.normal(size=(6, 3))
    np.testing.assert_allclose(apply(T_a_b @ T_b_c, P), apply(T_a_b, apply(T_b_c, P)), atol=1e-13)


@pytest.mark.parametrize("size", [0.0, 1e-12, 1e-4, 1.0, np.pi, 5.0])
def test_turn_vectors_agree_with_scipy(size: float) -> None:
    axis = RNG.normal(size=(20, 3))
    turn = size * axis / np.linalg.norm(axis, axis=1, keepdims=True)
    np.testing.assert_allclose(exp_so3(turn), Rotation.from_rotvec(turn).as_matrix(), atol=1e-14)


def test_half_a_turn_has_a_quaternion() -> None:
    q = np.concatenate([np.eye(4)[:3], RNG.normal(size=(20, 4)) * [1.0, 1.0, 1.0, 0.0]])
    np.testing.assert_allclose(from_quaternion(to_quaternion(from_quaternion(q))), from_quaternion(q), atol=1e-14)


@pytest.mark.parametrize("size", [0.0, 1e-12, 1e-5, 1.0, 3.0, np.pi - 1e-9, np.pi])
def test_a_rotation_gives_back_its_turn_vector(size: float) -> None:
    axis = RNG.normal(size=(20, 3))
    turn = size * axis / np.linalg.norm(axis, axis=1, keepdims=True)
    found = log_so3(exp_so3(turn))
    either_way = np.sign((found * turn).sum(axis=1, keepdims=True)) if size == np.pi else 1.0
    np.testing.assert_allclose(either_way * found, turn, atol=1e-13)


def test_exact_half_turns_and_no_turn_have_turn_vectors() -> None:
    half_turns = np.array([np.diag([1.0, -1.0, -1.0]), np.diag([-1.0, -1.0, 1.0]), np.eye(3)])
    np.testing.assert_array_equal(log_so3(half_turns), np.pi * np.array([[1, 0, 0], [0, 0, 1], [0, 0, 0]]))


@pytest.mark.parametrize("size", [1e-12, 1e-5, 2e-4, 1.0, 3.0])
def test_the_slopes_of_a_turn_vector_are_its_differences(size: float) -> None:
    turn = size * np.array([0.6, -0.48, 0.64])
    step = 1e-6 * np.eye(3)
    ends = [log_so3(exp_so3(turn) @ exp_so3(sign * step)) for sign in (1.0, -1.0)]
    small = Dual(np.zeros(3), np.eye(3), (0, 1, 2))
    np.testing.assert_allclose(
        log_so3(exp_so3(turn) @ exp_so3(small)).slopes.T, (ends[0] - ends[1]).T / 2e-6, atol=1e-9
    )


def test_quaternions_agree_with_scipy_and_come_back() -> None:
    R = motions(30)[:, :3, :3]
    q = to_quaternion(R)
    assert (q[:, 3] >= 0).all()
    np.testing.assert_allclose(Rotation.from_quat(q).as_matrix(), R, atol=1e-14)
    np.testing.assert_allclose(from_quaternion(3.0 * q), R, atol=1e-14)


def test_angles_agree_with_scipy_and_come_back() -> None:
    w, phi, psi = RNG.uniform(-1.5, 1.5, (3, 40))
    R = from_angles(w, phi, psi)
    np.testing.assert_allclose(R, Rotation.from_euler("XYZ", np.stack([w, phi, psi], 1)).as_matrix(), atol=1e-14)
    np.testing.assert_allclose(np.stack(to_angles(R)), np.stack([w, phi, psi]), atol=1e-12)
    R = from_angles(w, phi, psi, order="zyz")
    np.testing.assert_allclose(R, Rotation.from_euler("ZYZ", np.stack([w, phi, psi], 1)).as_matrix(), atol=1e-14)
    np.testing.assert_allclose(
        np.stack(to_angles(R, order="zyz"), 1), Rotation.from_matrix(R).as_euler("ZYZ"), atol=1e-12
    )


def test_skew_is_the_cross_product() -> None:
    a, b = RNG.normal(size=(2, 10, 3))
    np.testing.assert_allclose((skew(a) @ b[..., None])[..., 0], np.cross(a, b), atol=1e-15)


def test_a_rigid_fit_finds_the_motion() -> None:
    T, P = motions(7), RNG.normal(size=(7, 12, 3))
    np.testing.assert_allclose(rigid_fit(P, apply(T[:, None], P)), T, atol=1e-13)


def test_a_rigid_fit_of_a_flat_target_is_no_reflection() -> None:
    T, P = motions(7), RNG.normal(size=(7, 12, 3)) * [1.0, 1.0, 0.0]
    np.testing.assert_allclose(rigid_fit(P, apply(T[:, None], P)), T, atol=1e-13)


def test_no_motion_fits_better_than_the_fit() -> None:
    P = RNG.normal(size=(12, 3))
    Q = apply(motions(1)[0], P) + 0.1 * RNG.normal(size=(12, 3))

    def misfit(T: np.ndarray) -> float:
        return float(((apply(T, P) - Q) ** 2).sum())

    T = rigid_fit(P, Q)
    for _ in range(50):
        assert misfit(T @ pose(exp_so3(1e-3 * RNG.normal(size=3)), 1e-3 * RNG.normal(size=3))) >= misfit(T)


@pytest.mark.parametrize(("order", "phi"), [("xyz", np.pi / 2), ("xyz", -np.pi / 2), ("zyz", 0.0), ("zyz", np.pi)])
def test_angles_give_back_the_turn_where_only_the_sum_of_two_matters(order: str, phi: float) -> None:
    R = from_angles(np.array([0.3]), np.array([phi]), np.array([-1.1]), order=order)
    np.testing.assert_allclose(from_angles(*to_angles(R, order=order), order=order), R, atol=1e-12)


def test_the_nearest_rotation_is_one_and_none_lies_nearer() -> None:
    rng = np.random.default_rng(5)
    M = rng.normal(size=(20, 3, 3))
    R, s = nearest_rotation(M)
    np.testing.assert_allclose(R @ np.swapaxes(R, 1, 2), np.broadcast_to(np.eye(3), R.shape), atol=1e-12)
    np.testing.assert_allclose(np.linalg.det(R), 1.0)
    np.testing.assert_allclose((R * M).sum(axis=(1, 2)), s.sum(axis=1))
    assert ((exp_so3(rng.normal(size=(200, 1, 3)) * 2.0) * M).sum(axis=(2, 3)) <= s.sum(axis=1) + 1e-12).all()
