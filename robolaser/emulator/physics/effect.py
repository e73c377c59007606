"""Something in which the cell is not what its model says."""

from abc import ABC
from dataclasses import dataclass
from typing import ClassVar

from robolaser.arrays import Array
from robolaser.emulator.rendering import Sheet
from robolaser.trials.worlds.arm import Arm


@dataclass(frozen=True)
class Departure(ABC):
    """One departure; at size zero it changes nothing.

    Attributes:
        where: A joint, or "laser".
        size: SI.
    """

    name: ClassVar[str]
    on_joints: ClassVar[bool] = True

    where: str
    size: float

    def follow(self, motor: float, last: float, hanging: float) -> float:
        """How far the link hangs behind, the motor having gone straight to `motor` from `last` [rad]."""
        return 0.0

    def joints(self, q: Array, column: int, hanging: float, arm: Arm) -> Array:
        """Joint angles as they are, of what the motors' encoders say, (j,) [rad]."""
        return q

    def light(self, sheet: Sheet) -> Sheet:
        """The light as it is."""
        return sheet


def shifted(q: Array, column: int, by: float) -> Array:
    """The same but for one joint, (j,) [rad]."""
    q = q.copy()
    q[column] += by
    return q
