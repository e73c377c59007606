"""Faults of the instrument that measures the arm."""

from dataclasses import dataclass
from typing import ClassVar, final

from robolaser.arrays import Array
from robolaser.trials.synthetic.fault_model import FaultModel
from robolaser.trials.synthetic.run import SyntheticRun


@final
@dataclass(frozen=True)
class WrongRefractiveIndex(FaultModel):
    """The tracker takes the air for another one: all its lengths are too long by the share `size`."""

    effect: ClassVar[str] = "tracker_scale"
    sizes: ClassVar[tuple[float, float]] = (2e-5, 1e-3)
    signed: ClassVar[bool] = True
    location: ClassVar[str | None] = "measuring_system"

    @property
    def also_right(self) -> tuple[tuple[str, str], ...]:
        """The arm may have grown: without a known length nobody can tell."""
        return (("arm_scale", "base"),)

    def values(self, run: SyntheticRun) -> dict[str, float]:
        """Of the library's number."""
        return {"scale": self.size}

    def measured(self, points: Array) -> Array:
        """Farther away."""
        return points * (1.0 + self.size)
