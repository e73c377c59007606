"""Rigid motions of what the flange carries, a share of them at each pose."""

from collections.abc import Sequence
from typing import Final

import numpy as np

from robolaser.arrays import Array, Bools
from robolaser.geometry.rigid_motion import exp_so3, pose

SETTLINGS: Final = (0.0, 1.5, 3.5, 8.0)
"""Of a creep, to try: with the first it is even, with the last it ends in the first third of the run."""


def moved(T: Array, shift: Sequence[Array], turn: Sequence[Array], share: Array | Bools) -> Array:
    """Poses T (c, n, 4, 4) moved in their own frames, by a share (c, n) of a shift [m] and of a rotation vector [rad].

    The three components of either are of each candidate, (c,).
    """
    by_pose = share[..., None]
    shifts, turns = (by_pose * np.stack(one, axis=-1)[:, None] for one in (shift, turn))
    there: Array = T @ pose(exp_so3(turns), shifts)
    return there
