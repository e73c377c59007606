"""Moments of a run from which on something is elsewhere."""

from typing import Final

import numpy as np

from robolaser.arrays import Array, Bools
from robolaser.data.dataset import Dataset
from robolaser.model.effects.run import Run

FEWEST: Final = 3
"""Poses before and after a moment: any six numbers fit fewer."""


def enough_poses(dataset: Dataset) -> str:
    """There are enough poses before and after any moment."""
    return f"fewer than {2 * FEWEST} poses" if len(dataset.poses) < 2 * FEWEST else ""


def moments(run: Run) -> Array:
    """The middle of each pause between poses with points as a share of the run, (g,), enough poses on either side."""
    at = np.sort(run.progress_of_all[np.unique(run.dataset.points.pose)])
    between = (at[FEWEST - 1 : -FEWEST] + at[FEWEST : len(at) - FEWEST + 1]) / 2
    return np.unique(between if len(between) else [0.5])


def later(run: Run, moment: Array) -> Bools:
    """Which poses of a run came after the moment of each candidate (c,), (c, n)."""
    return np.asarray(run.progress_of_all > moment[:, None])
