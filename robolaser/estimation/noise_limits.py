"""The largest errors that count as noise: of poses by the data sheet or what is usual, of rows by the detector."""

from collections.abc import Collection, Mapping
from typing import Final

import numpy as np

from robolaser.data.dataset import Dataset
from robolaser.model.error_source import ErrorSource

LARGEST_SCATTER: Final = {"m": 3e-4, "rad": 5e-4}
"""Scatter of whole poses that chance may cause [m, rad]: more is a gap. Arms repeat to 0.02 mm, hobby arms to 0.5 mm
at the end of half a metre. Without a limit, poses that are free to move explain any error of a sensor."""
LARGEST_ROW_ERROR: Final = {"px": 1.0}
"""Error of a detected corner or line centre that chance may cause [px]: more is a gap. Detectors place saddle points to
0.1 px and better (Lucchese, Mitra 2002, Using saddle points for subpixel feature detection), peaks of a stripe to
0.3 px (Naidu, Fisher 1991, A comparative analysis of algorithms for determining the peak position of a stripe)."""
LEVER_M: Final = 0.3
"""Distance, at which a turn counts as the shift that it makes there. A judgement."""


def noise_limits(sources: Collection[ErrorSource], dataset: Dataset, *, alone: bool) -> Mapping[str, float]:
    """The largest standard deviation that counts as noise, by name of source and in its unit, where there is a limit.

    A stated repeatability limits the root-mean-square shift of the flange that a source causes by itself. Readings in
    coarse steps may err by these, too.

    Args:
        sources: The noise sources of the rows.
        dataset: With the arm's poses and the stated repeatability.
        alone: Whether each pose has one row: then the row's errors are the pose's.
    """
    stated = dataset.noise.repeatability_m
    rounding = dataset.noise.rounding_rad
    usual = {}
    for source in sources:
        of_pose = alone or source.level == "pose"
        largest = LARGEST_ROW_ERROR | (LARGEST_SCATTER if of_pose else {})
        if source.unit in largest:
            usual[source.name] = largest[source.unit]
    if "joint" in usual:
        usual["joint"] = float(np.hypot(usual["joint"], rounding))
    if stated is None:
        return usual
    axis = stated / np.sqrt(3.0)
    return usual | {
        source.name: float(np.hypot(stated / _reach(dataset), rounding))
        if source.name == "joint"
        else axis
        if source.unit == "m"
        else axis / LEVER_M
        for source in sources
        if source.level == "pose"
    }


def _reach(dataset: Dataset) -> float:
    """Shift of the flange by a unit error of each joint, root mean square over the poses with points [m/rad]."""
    robot, q = dataset.arm
    J = robot.jacobian(q[None, np.unique(dataset.points.pose)])[0, :, :3]
    return float(np.sqrt(np.square(J).sum(axis=(1, 2)).mean()))
