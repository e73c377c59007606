"""The largest scatter of whole poses that counts as noise: by the arm's data sheet, else what is usual for arms."""

from collections.abc import Iterable, Mapping

import numpy as np

from robolaser.arrays import Array
from robolaser.data.dataset import Dataset
from robolaser.diagnosis.thresholds import LARGEST_SCATTER, LEVER_M
from robolaser.finite_differences import central_differences
from robolaser.model.error_source import ErrorSource

STEP_RAD = 1e-5


def scatter_limits(sources: Iterable[ErrorSource], dataset: Dataset, *, alone: bool) -> Mapping[str, float]:
    """The largest standard deviation that counts as noise, by name of source and in its unit, where there is a limit.

    A stated repeatability limits the root-mean-square shift of the flange that a source causes by itself.

    Args:
        sources: The noise sources of the rows.
        dataset: With the arm's poses and the stated repeatability.
        alone: Whether each pose has one row: then the row's errors are the pose's.
    """
    stated = dataset.noise.repeatability_m
    of_poses = {source.name: source for source in sources if source.level == "pose"}
    rows = {source.name: source for source in sources if alone and source.unit in LARGEST_SCATTER}
    usual = {name: LARGEST_SCATTER[source.unit] for name, source in (rows | of_poses).items()}
    if stated is None:
        return usual
    axis = stated / np.sqrt(3.0)
    return usual | {
        name: stated / _reach(dataset) if name == "joint" else axis if source.unit == "m" else axis / LEVER_M
        for name, source in of_poses.items()
    }


def _reach(dataset: Dataset) -> float:
    """Shift of the flange by a unit error of each joint, root mean square over the poses with points [m/rad]."""
    robot, q = dataset.arm
    q = q[np.unique(dataset.points.pose)]

    def places(turns: Array) -> Array:
        moved = np.repeat(q[None], len(turns), axis=0)
        moved[:, :, list(robot.chain)] += turns[:, None]
        return np.asarray(robot.forward(moved)[..., :3, 3])

    J = central_differences(places, np.full(len(robot.chain), STEP_RAD))
    return float(np.sqrt(np.square(J).sum(axis=(1, 2)).mean()))
