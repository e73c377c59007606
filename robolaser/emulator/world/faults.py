"""What world.toml may set wrong in an emulated arm or laser, by the fault models of the blind trials."""

from collections.abc import Callable, Mapping
from dataclasses import dataclass, field, replace
from typing import Self, final

import numpy as np

from robolaser.arrays import Array
from robolaser.trials.synthetic.fault_model import FaultModel
from robolaser.trials.synthetic.fault_models.joints import (
    EncoderGain,
    OffCentreEncoder,
    ShiftedZero,
    TransmissionRipple,
    play_lag,
    turned,
)
from robolaser.trials.synthetic.fault_models.light import ConicalLight, ProjectorRoll
from robolaser.trials.synthetic.run import SyntheticRun


@final
class TrackedBacklash(FaultModel, effect="backlash"):
    """The link trails its motor by half the play, `size` [rad], on the side that it came from.

    Attributes:
        engagement: Travel over which friction takes the play up to a third [rad]; 0: the teeth are hard.
        lag: How far the link trails now [rad].
    """

    engagement: float = 0.0
    lag: float = 0.0

    def moved(self, move: float) -> Self:
        """The same gear once its motor has gone on without turning back [rad]."""
        if self.engagement == 0.0:
            return replace(self, lag=play_lag(self.lag, move, self.size))
        end = self.size / 2 * float(np.sign(move))
        return replace(self, lag=end + (self.lag - end) * float(np.exp(-abs(move) / self.engagement)))

    def joints(self, q: Array, run: SyntheticRun) -> Array:
        """Behind."""
        return turned(q, run.column(self.where), -self.lag)


@final
class LinearCompliance(FaultModel, effect="joint_compliance"):
    """The joint gives way by `size` for each newton metre [rad/Nm], `payload_kg` on the flange included."""

    payload_kg: float = 0.0

    def joints(self, q: Array, run: SyntheticRun) -> Array:
        """Deflected."""
        column = run.column(self.where)
        return turned(q, column, -self.size * run.arm.torques(q, self.payload_kg)[:, column])


def _ripple(where: str, size: float, cycles: float, phase: float) -> TransmissionRipple:
    return TransmissionRipple(where, size, cycles, 0.0, (phase, 0.0))


@final
@dataclass(frozen=True)
class WorldFault:
    """One kind of fault that world.toml may name.

    Attributes:
        make: From location, size and parameters.
        parameters: Its further keys, with their defaults.
        on_joints: Whether it is a joint's, not the laser's.
    """

    make: Callable[..., FaultModel]
    parameters: Mapping[str, float] = field(default_factory=dict)
    on_joints: bool = True


WORLD_FAULTS: Mapping[str, WorldFault] = {
    "backlash": WorldFault(TrackedBacklash, {"engagement": 0.0}),
    "encoder_eccentricity": WorldFault(OffCentreEncoder, {"towards": 0.0}),
    "encoder_scale": WorldFault(EncoderGain),
    "joint_compliance": WorldFault(LinearCompliance, {"payload_kg": 0.0}),
    "joint_offset": WorldFault(ShiftedZero),
    "laser_curvature": WorldFault(ConicalLight, on_joints=False),
    "laser_roll": WorldFault(ProjectorRoll, on_joints=False),
    "transmission_error": WorldFault(_ripple, {"cycles": 8.0, "phase": 0.0}),
}
"""By name."""
