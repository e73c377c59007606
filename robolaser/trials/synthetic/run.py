"""A run of the cell: where the arm was told to stand, when, how fast it passed, and above which target."""

from dataclasses import dataclass
from typing import final

import numpy as np

from robolaser.arrays import Array, Ints
from robolaser.trials.synthetic.arm import ScrewArm


@final
@dataclass(frozen=True)
class SyntheticRun:
    """What a fault may depend on."""

    arm: ScrewArm  # the nominal arm
    q: Array  # joint angles as read, (n, j) [rad or m]
    qd: Array  # velocities at the reading, (n, j) [rad/s or m/s]
    time: Array  # of each pose, (n,) [s]
    middle: Array  # of the target, (3,) in the base frame [m]
    radius: float  # of the part of the target that is looked at [m]
    payload_kg: float  # what the flange carries; the URDF does not know of it

    @property
    def share(self) -> Array:
        """How far the run is, 0 to 1, (n,)."""
        return np.asarray((self.time - self.time.min()) / max(1e-9, float(np.ptp(self.time))))

    @property
    def order(self) -> Ints:
        """The poses as they came, (n,)."""
        return np.argsort(self.time, kind="stable")

    def column(self, joint: str) -> int:
        """The column of a joint in q."""
        return self.arm.columns[self.arm.joints.index(joint)]

    def relative_torque(self, joint: str) -> Array:
        """What a joint bears, the payload counted, over the most that it bears in the run, (n,)."""
        torque = self.arm.torques(self.q, self.payload_kg)[:, self.column(joint)]
        return np.asarray(torque / max(1e-9, float(np.abs(torque).max())))

    def warmed(self, tau: float) -> Array:
        """0 at the start, towards 1 with a time constant, a share of the run, (n,)."""
        return 1.0 - np.exp(-self.share / tau)
