"""Joints that are measured before they are at rest, or read at another time than the image."""

from dataclasses import dataclass
from typing import Any, ClassVar, final

import numpy as np

from robolaser.arrays import Array
from robolaser.trials.synthetic.fault_model import FaultModel
from robolaser.trials.synthetic.fault_models.joints import turned
from robolaser.trials.synthetic.run import SyntheticRun


@final
@dataclass(frozen=True)
class LateExposure(FaultModel):
    """The camera exposes `size` [s] after the reading, while the arm moves on and brakes."""

    effect: ClassVar[str] = "latency"
    sizes: ClassVar[tuple[float, float]] = (3e-4, 8e-3)
    signed: ClassVar[bool] = True

    braking: float

    @classmethod
    def sample_form(cls, where: str, run: SyntheticRun, rng: np.random.Generator) -> tuple[Any, ...]:
        """Time constant of the braking [s]."""
        return (rng.uniform(0.01, 0.1),)

    @classmethod
    def locations(cls, run: SyntheticRun) -> tuple[str, ...]:
        """Between controller and camera; in an arm at rest it changes nothing."""
        return ("timing",) if run.qd.any() else ()

    def values(self, run: SyntheticRun) -> dict[str, float]:
        """Of the library's number."""
        return {"delay": float(np.sign(self.size) * self._waited)}

    def joints(self, q: Array, run: SyntheticRun) -> Array:
        """Where the arm was when the shutter opened."""
        moved: Array = q + run.qd * np.sign(self.size) * self._waited
        return moved

    @property
    def _waited(self) -> float:
        return float(-self.braking * np.expm1(-abs(self.size) / self.braking))


@final
@dataclass(frozen=True)
class LateArrival(FaultModel):
    """The joint creeps towards its goal and is measured before it is there, sooner at some poses than at others."""

    effect: ClassVar[str] = "settling"
    sizes: ClassVar[tuple[float, float]] = (2e-4, 4e-3)
    signed: ClassVar[bool] = True

    waits: float

    @classmethod
    def sample_form(cls, where: str, run: SyntheticRun, rng: np.random.Generator) -> tuple[Any, ...]:
        """Waits at the poses, in time constants."""
        return (rng.uniform(4.0, 8.0),)

    def joints(self, q: Array, run: SyntheticRun) -> Array:
        """Short of its goal by a share `size` of the way from where it stood before, at the middle one of the waits."""
        column, order = run.column(self.where), run.order
        pause = np.diff(run.time[order], prepend=run.time[order][0])
        usual = float(np.median(pause[1:]))
        shares = self.size * np.exp(-0.1 * self.waits * (pause / usual - 1.0))
        short = np.zeros(len(q))
        for i in range(1, len(order)):
            before = q[order[i - 1], column] - short[order[i - 1]]
            short[order[i]] = shares[i] * (q[order[i], column] - before)
        return turned(q, column, -short)
