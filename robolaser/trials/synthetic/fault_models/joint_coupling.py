"""Joints that other joints turn."""

from abc import abstractmethod
from dataclasses import dataclass
from typing import Annotated, final

import numpy as np

from robolaser.arrays import Array
from robolaser.trials.synthetic.fault_model import Coin, FaultModel, uniform
from robolaser.trials.synthetic.fault_models.joints import turned
from robolaser.trials.synthetic.run import SyntheticRun


def _neighbour(where: str, run: SyntheticRun, rng: np.random.Generator) -> str:
    """A joint at most two joints away."""
    at = run.arm.joints.index(where)
    return str(rng.choice([joint for i, joint in enumerate(run.arm.joints) if abs(i - at) in (1, 2)]))


@dataclass(frozen=True)
class Coupling(FaultModel):
    """Another joint turns this one."""

    other: Annotated[str, _neighbour]

    @classmethod
    def locations(cls, run: SyntheticRun) -> tuple[str, ...]:
        """Every joint that has a neighbour."""
        return run.arm.joints if len(run.arm.joints) > 1 else ()

    def sites(self, run: SyntheticRun) -> tuple[str, ...]:
        """Either joint."""
        return self.where, self.other

    def joints(self, q: Array, run: SyntheticRun) -> Array:
        """Turned on by where the other joint is in its range over the run, -1 to 1."""
        middle, half = self._range(run)
        swing: Array = (run.q[:, run.column(self.other)] - middle) / half
        return turned(q, run.column(self.where), self.size * self.share(swing))

    @abstractmethod
    def share(self, swing: Array) -> Array:
        """Of the size by which it turns, (n,)."""

    def _range(self, run: SyntheticRun) -> tuple[float, float]:
        """The middle of what the other joint goes over, and half of its length [rad or m]."""
        read = run.q[:, run.column(self.other)]
        return float(read.max() + read.min()) / 2, max(1e-9, float(np.ptp(read))) / 2


@final
@dataclass(frozen=True)
class LedAlong(Coupling, effect="joint_coupling", sizes=(4e-4, 4e-3), signed=True):
    """A belt is led along another joint, whose motion turns this one, with a little ripple of its pulley."""

    homed: Annotated[float, uniform(-1.0, 1.0)]  # where in its range both were homed

    def values(self, run: SyntheticRun) -> dict[str, float]:
        """Of a belt without ripple."""
        middle, half = self._range(run)
        ratio, homed = self.size / half, middle + self.homed * half
        return {"ratio": ratio, "offset": -ratio * homed, "other": 1.0 + run.arm.joints.index(self.other)}

    def share(self, swing: Array) -> Array:
        """All of it across half the other's range."""
        return swing - self.homed + 0.03 * np.sin(5.0 * swing)


@final
@dataclass(frozen=True)
class CrossTalk(Coupling, effect="cross_talk", sizes=(4e-4, 4e-3), classes=("transmission",)):
    """Another joint turns this one, but not in proportion to its angle; the library has no such effect."""

    even: Coin

    @property
    def also_right(self) -> tuple[tuple[str, str], ...]:
        """The nearest that the library has."""
        return (("joint_coupling", self.where),)

    def share(self, swing: Array) -> Array:
        """To and fro, or by the square of the swing."""
        return swing**2 if self.even else np.sin(np.pi * swing)
