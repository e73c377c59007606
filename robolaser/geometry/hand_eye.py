"""Hand-eye and robot-world: A X = Z B in closed form, from pairs of poses alone.

A camera on the flange sees a board in the cell: A is T_base_flange, X T_flange_camera, Z T_base_board and B
T_camera_board inverted. A camera in the cell sees a board on the flange: X is T_flange_board, Z T_base_camera and B
T_camera_board. Two systems that track one body each: X and Z are the motions between the bodies and between the
systems. The usual A X = X B is the same for pairs of such pairs.

Shah 2013, Solving the robot-world/hand-eye calibration problem using the Kronecker product: R_Z = R_A R_X R_Bᵀ is
linear in all entries, so the rotations that fit best are a pair of singular vectors: no start is needed.
"""

import numpy as np

from robolaser.arrays import Array, Ints
from robolaser.errors import EstimationError
from robolaser.geometry.rigid_motion import exp_so3, log_so3, nearest_rotation, pose, skew

LEAST_TURN = np.deg2rad(2.0)  # root-mean-square turn about a second axis below which a hand-eye is not determined
ALTERNATIONS = 200  # of the two rotations, each the best for the other; mostly ten suffice
LEAST_TRAVEL = 0.05  # least ratio of the second principal axis to the first; else travel is along a line. A judgement.
SETTLED = 1e-13  # change of a rotation's entries below which they have converged


def turn_about_second_axis(R: Array) -> float:
    """Root-mean-square turn of rotations (n, 3, 3) about the second of their principal axes [rad].

    Zero where all turns are about one axis, or there are none: then turns alone determine no hand-eye.
    """
    return float(principal_turns(R)[1][1]) if len(R) > 1 else 0.0


def principal_turns(R: Array) -> tuple[Array, Array, Array]:
    """The mean of rotations (n, 3, 3), their turns about each principal axis (3,) [rad], and these axes, (3, 3)."""
    M = mean_rotation(R)
    turns = log_so3(M.T @ R)
    _, sizes, axes = np.linalg.svd(turns - turns.mean(axis=0), full_matrices=False)
    return M, np.pad(sizes, (0, 3 - len(sizes))) / np.sqrt(len(R)), axes


def robot_world_hand_eye(
    A: Array, B: Array, of: Ints | None = None, *, X: Array | None = None, Z: Array | None = None
) -> tuple[Array, Array]:
    """X and Z with A X = Z B as nearly as can be: rotations first, then translations.

    Args:
        A: Motions, (n, 4, 4).
        B: Motions, (n, 4, 4).
        of: Number of each pair's X, (n,), from 0: several bodies share one Z. The same for all when absent.
        X: All of them where they are known, (t, 4, 4).
        Z: Where it is known, (4, 4).

    Returns:
        X (t, 4, 4) and Z (4, 4).
    """
    of = np.zeros(len(A), dtype=np.int64) if of is None else of
    bodies = int(of.max()) + 1
    R_A, R_B = A[:, :3, :3], B[:, :3, :3]
    if X is not None:
        R_X = X[:, :3, :3]
        R_Z = mean_rotation(R_A @ R_X[of] @ np.swapaxes(R_B, 1, 2)) if Z is None else Z[:3, :3]
    else:
        R_Z = _shah(R_A, R_B, of, bodies) if Z is None else Z[:3, :3]
        R_X = _each(np.swapaxes(R_A, 1, 2) @ R_Z @ R_B, of, bodies)
        for _ in range(ALTERNATIONS if Z is None else 0):
            before, R_Z = R_Z, mean_rotation(R_A @ R_X[of] @ np.swapaxes(R_B, 1, 2))
            R_X = _each(np.swapaxes(R_A, 1, 2) @ R_Z @ R_B, of, bodies)
            if np.abs(R_Z - before).max() < SETTLED:
                break
    t_X, t_Z = _translations(A, B, R_Z, of, None if X is None else X[:, :3, 3], None if Z is None else Z[:3, 3])
    return pose(R_X, t_X), pose(R_Z, t_Z)


def _shah(R_A: Array, R_B: Array, of: Ints, bodies: int) -> Array:
    """R_Z, (3, 3): the left singular vector of Σ R_B ⊗ R_A over the pairs of each body, side by side."""
    K = np.zeros((bodies, 9, 9))
    np.add.at(K, of, np.einsum("nij,nkl->nikjl", R_B, R_A).reshape(-1, 9, 9))
    U, _, _ = np.linalg.svd(np.concatenate(K, axis=1))
    M = U[:, 0].reshape(3, 3).T  # vec() stacks columns
    R, _ = nearest_rotation(M if np.linalg.det(M) > 0 else -M)
    return R


def _translations(
    A: Array, B: Array, R_Z: Array, of: Ints, t_X: Array | None, t_Z: Array | None
) -> tuple[Array, Array]:
    """R_A t_X + t_A = R_Z t_B + t_Z in least squares, (t, 3) and (3,)."""
    n, bodies = len(A), int(of.max()) + 1
    right = B[:, :3, 3] @ R_Z.T - A[:, :3, 3]
    if t_X is not None and t_Z is not None:
        return t_X, t_Z
    by_body = np.zeros((n, 3, bodies, 3))
    by_body[np.arange(n), :, of] = A[:, :3, :3]
    carried = by_body.reshape(3 * n, -1)
    if t_X is not None:
        return t_X, np.asarray(((carried @ t_X.ravel()).reshape(n, 3) - right).mean(axis=0))
    if t_Z is not None:
        found = np.linalg.lstsq(carried, (right + t_Z).ravel(), rcond=None)[0]
        return np.asarray(found.reshape(-1, 3)), t_Z
    design = np.concatenate([carried, np.tile(-np.eye(3), (n, 1))], axis=1)
    found = np.linalg.lstsq(design, right.ravel(), rcond=None)[0]
    return np.asarray(found[:-3].reshape(-1, 3)), np.asarray(found[-3:])


def _each(R: Array, of: Ints, bodies: int) -> Array:
    """The rotation nearest to the rotations of each body, (t, 3, 3)."""
    return np.stack([mean_rotation(R[of == body]) for body in range(bodies)])


def mean_rotation(R: Array) -> Array:
    """The rotation nearest to some (n, 3, 3), (3, 3)."""
    nearest, _ = nearest_rotation(R.sum(axis=0))
    return nearest


def hand_eye_by_travel(A: Array, B: Array) -> tuple[Array, Array]:
    """X and Z, (4, 4) each, with A X = Z B as nearly as can be, (n, 4, 4), where A turns about one axis at most.

    Turns about one axis a leave R_Z free to turn about a; without any turn R_Z is free altogether. Then the travels of
    A and B, in their own frames, determine the rest: R_Z t_B = t_A + R_A t_X - t_Z. The part of t_X that no turn
    moves, along a or all of it, is in no data: it is zero here, and included in t_Z.

    Raises:
        EstimationError: A neither turns nor travels in two directions.
    """
    R_A, R_B, t_A, t_B = A[:, :3, :3], B[:, :3, :3], A[:, :3, 3], B[:, :3, 3]
    travel, seen, turning = t_A - t_A.mean(axis=0), t_B - t_B.mean(axis=0), R_A - R_A.mean(axis=0)
    M, turns, axes = principal_turns(R_A)
    if turns[0] < LEAST_TURN:
        breadth = np.linalg.svd(travel, compute_uv=False)
        if breadth[1] < LEAST_TRAVEL * breadth[0]:
            raise EstimationError(
                "The flange neither turns nor moves in two directions: no hand-eye can be found from that. Add poses"
                " that tilt the flange in two directions by 20 degrees or more."
            )
        R_Z, _ = nearest_rotation(np.einsum("ni,nj->ij", travel, seen))
    else:
        found = robot_world_hand_eye(A, B)[1]
        axis = M @ axes[0]
        before = seen @ found[:3, :3].T
        along = np.outer(before @ axis, axis)
        across = before - along
        turned = np.stack([across, across @ skew(axis).T], axis=2)  # by the cosine and by the sine of its turn
        design = np.concatenate([turned, -turning], axis=2).reshape(-1, 5)
        cosine, sine = np.linalg.lstsq(design, (travel - along).ravel(), rcond=None)[0][:2]
        R_Z = exp_so3(np.arctan2(sine, cosine) * axis) @ found[:3, :3]
    R_X = mean_rotation(np.swapaxes(R_A, 1, 2) @ R_Z @ R_B)
    stacked = turning.reshape(-1, 3) / np.sqrt(len(A))
    U, s, Vt = np.linalg.svd(stacked, full_matrices=False)
    known = s > LEAST_TURN
    t_X = Vt[known].T @ ((U[:, known].T @ ((seen @ R_Z.T - travel).ravel() / np.sqrt(len(A)))) / s[known])
    t_Z = (R_A @ t_X + t_A - t_B @ R_Z.T).mean(axis=0)
    return pose(R_X, t_X), pose(R_Z, t_Z)


def undetermined_reason(T_base_flange: Array) -> str:
    """A sentence where flange poses (n, 4, 4) turn about one axis only, or not at all; "" where they turn about two."""
    about_second = turn_about_second_axis(T_base_flange[:, :3, :3])
    if about_second >= LEAST_TURN:
        return ""
    return (
        "All poses have one orientation of the flange, or turn it about one axis only"
        f" ({np.degrees(about_second):.1f}° about a second one): what is on the flange cannot be distinguished from"
        " what is in the cell. Measure poses that turn the flange about two axes, by"
        f" {np.degrees(LEAST_TURN):.0f}° at least and better by 30°."
    )
