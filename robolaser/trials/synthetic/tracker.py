"""A cell in which a tracker sees reflectors on the flange, and where it sees them with given faults."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import final

import numpy as np

from robolaser.arrays import Array, Ints
from robolaser.trials.synthetic.cell import Readings
from robolaser.trials.synthetic.fault_model import FaultModel, flange_poses
from robolaser.trials.synthetic.run import SyntheticRun


@final
@dataclass(frozen=True)
class TrackerCell:
    """Where everything truly is, save the faults. In each pose all reflectors are seen."""

    run: SyntheticRun  # of the arm
    T_world_base: Array  # (4, 4)
    reflectors: Mapping[str, Array]  # in the flange's frame, by name, (3,) [m]

    @property
    def pose(self) -> Ints:
        """Number of each point's pose, (m,)."""
        return np.repeat(np.arange(len(self.run.q)), len(self.reflectors))

    @property
    def truth(self) -> dict[str, float]:
        """No ordinary parameter of the sensor: all of them follow from the points."""
        return {}

    def seen(self, faults: Sequence[FaultModel]) -> Readings:
        """Go the chain forwards, from the joints to the points in the tracker's frame."""
        T = self.T_world_base @ flange_poses(self.run, faults)
        at = np.array(list(self.reflectors.values()))
        points = (np.einsum("nab,kb->nka", T[:, :3, :3], at) + T[:, None, :3, 3]).reshape(-1, 3)
        for fault in faults:
            points = fault.measured(points)
        return Readings(np.empty((len(points), 0)), points)
