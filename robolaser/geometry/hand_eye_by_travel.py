"""A X = Z B where A turns about one axis only, or not at all: what its travel tells.

Turns about one axis a leave R_Z free to turn about a; without any turn R_Z is free altogether. Then the way that A goes
and the one that B goes, seen in their own frames, fix the rest: R_Z t_B = t_A + R_A t_X - t_Z. What no turn moves of
t_X, its part along a or all of it, is in no data: it is zero here, and t_Z holds it.
"""

import numpy as np

from robolaser.arrays import Array
from robolaser.errors import EstimationError
from robolaser.geometry.hand_eye import LEAST_TURN, mean_rotation, principal_turns, robot_world_hand_eye
from robolaser.geometry.rigid_motion import exp_so3, nearest_rotation, pose, skew

LEAST_TRAVEL = 0.05
"""Second principal axis of the travel over the first, below which it is along one line. A judgement."""


def hand_eye_by_travel(A: Array, B: Array) -> tuple[Array, Array]:
    """X and Z, (4, 4) each, with A X = Z B as nearly as can be.

    Args:
        A: Motions that turn about one axis at most, (n, 4, 4).
        B: Motions, (n, 4, 4).

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
