"""Joints that sink under the weight of the arm."""

from dataclasses import dataclass
from typing import ClassVar, final

from robolaser.arrays import Array
from robolaser.emulator.physics.effect import Departure, shifted
from robolaser.trials.worlds.arm import Arm


@final
@dataclass(frozen=True)
class Sag(Departure):
    """The joint gives way by `size` for each newton metre [rad/Nm], `payload_kg` on the flange counted."""

    name: ClassVar[str] = "joint_compliance"

    payload_kg: float = 0.0

    def joints(self, q: Array, column: int, hanging: float, arm: Arm) -> Array:
        """Sunk, by the torque that Pinocchio gives."""
        torque = float(arm.torques(q[None], self.payload_kg)[0, column])
        return shifted(q, column, -self.size * torque)
