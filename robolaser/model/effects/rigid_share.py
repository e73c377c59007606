"""Rigid motions in the course of a run, of which a share has happened at each pose."""

from collections.abc import Sequence

import numpy as np

from robolaser.arrays import Array, Bools
from robolaser.geometry.rigid_motion import exp_so3, pose


def moved(T: Array, shift: Sequence[Array], turn: Sequence[Array], share: Array | Bools) -> Array:
    """Poses T (c, n, 4, 4) moved in their own frames, by a share (c, n) of a shift [m] and of a rotation vector [rad].

    The three components of either are of each candidate, (c,).
    """
    shifts, R = _shares(shift, turn, share)
    there: Array = T @ pose(R, shifts)
    return there


def moved_about(middle: Array, T: Array, shift: Sequence[Array], turn: Sequence[Array], share: Array | Bools) -> Array:
    """The same in the base frame: turned about a point (3,), then shifted. It keeps turn and shift separable."""
    shifts, R = _shares(shift, turn, share)
    turned = R - np.eye(3)
    R, t = T[..., :3, :3], T[..., :3, 3]
    return pose(R + turned @ R, t + (turned @ (t - middle)[..., None])[..., 0] + shifts)


def about_another(middle: Array, other: Array, shift: Sequence[Array], turn: Sequence[Array]) -> Array:
    """The shift (3, 1) of a motion about a point (3,) that is described about another one, of one candidate."""
    R = exp_so3(np.stack(turn, axis=-1))[0]
    return np.asarray(np.stack(shift) + ((R - np.eye(3)) @ (other - middle))[:, None])


def _shares(shift: Sequence[Array], turn: Sequence[Array], share: Array | Bools) -> tuple[Array, Array]:
    """Shifts (c, n, 3) and rotations (c, n, 3, 3)."""
    by_pose = share[..., None]
    shifts, turns = (by_pose * np.stack(one, axis=-1)[:, None] for one in (shift, turn))
    return shifts, exp_so3(turns)
