"""Joints that other joints turn."""

from dataclasses import dataclass
from typing import Any, ClassVar, final

import numpy as np

from robolaser.arrays import Array
from robolaser.trials.synthetic.fault_model import FaultModel
from robolaser.trials.synthetic.fault_models.joints import turned
from robolaser.trials.synthetic.run import SyntheticRun


@final
@dataclass(frozen=True)
class LedAlong(FaultModel):
    """A belt is led along another joint, whose motion turns this one, with a little ripple of its pulley."""

    effect: ClassVar[str] = "joint_coupling"
    sizes: ClassVar[tuple[float, float]] = (4e-4, 4e-3)
    signed: ClassVar[bool] = True

    other: str
    homed: float

    @classmethod
    def sample_form(cls, where: str, run: SyntheticRun, rng: np.random.Generator) -> tuple[Any, ...]:
        """One of the neighbours, at most two joints away, and where in its range both were homed (-1 to 1)."""
        return _neighbour(where, run, rng), rng.uniform(-1.0, 1.0)

    @classmethod
    def locations(cls, run: SyntheticRun) -> tuple[str, ...]:
        """Every joint that has a neighbour."""
        return run.arm.joints if len(run.arm.joints) > 1 else ()

    def values(self, run: SyntheticRun) -> dict[str, float]:
        """Of the library's numbers."""
        read, ratio = run.q[:, run.column(self.other)], self.size / _half_range(run, self.other)
        homed = (read.max() + read.min()) / 2 + self.homed * _half_range(run, self.other)
        return {"ratio": ratio, "offset": -ratio * float(homed), "other": 1.0 + run.arm.joints.index(self.other)}

    def joints(self, q: Array, run: SyntheticRun) -> Array:
        """Turned on by up to `size` [rad] across half the other's range."""
        swing = _swing(run, self.other)
        return turned(q, run.column(self.where), self.size * (swing - self.homed + 0.03 * np.sin(5.0 * swing)))


@final
@dataclass(frozen=True)
class CrossTalk(FaultModel):
    """Another joint turns this one, but not in proportion to its angle; the library has no such effect."""

    effect: ClassVar[str] = "cross_talk"
    sizes: ClassVar[tuple[float, float]] = (4e-4, 4e-3)
    classes: ClassVar[tuple[str, ...]] = ("transmission",)

    other: str
    even: bool

    @classmethod
    def sample_form(cls, where: str, run: SyntheticRun, rng: np.random.Generator) -> tuple[Any, ...]:
        """One of the neighbours, at most two joints away."""
        return _neighbour(where, run, rng), bool(rng.random() < 0.5)

    @classmethod
    def locations(cls, run: SyntheticRun) -> tuple[str, ...]:
        """Every joint that has a neighbour."""
        return run.arm.joints if len(run.arm.joints) > 1 else ()

    @property
    def also_right(self) -> tuple[tuple[str, str], ...]:
        """The nearest that the library has."""
        return (("joint_coupling", self.where),)

    def joints(self, q: Array, run: SyntheticRun) -> Array:
        """Turned on by up to `size` [rad] across the other's range: to and fro, or by the square of its swing."""
        swing = _swing(run, self.other)
        return turned(q, run.column(self.where), self.size * (swing**2 if self.even else np.sin(np.pi * swing)))


def _neighbour(where: str, run: SyntheticRun, rng: np.random.Generator) -> str:
    """A joint at most two joints away."""
    at = run.arm.joints.index(where)
    return str(rng.choice([joint for i, joint in enumerate(run.arm.joints) if abs(i - at) in (1, 2)]))


def _swing(run: SyntheticRun, joint: str) -> Array:
    """Where in its range over the run a joint is, -1 to 1, (n,)."""
    read = run.q[:, run.column(joint)]
    swing: Array = (read - (read.max() + read.min()) / 2) / _half_range(run, joint)
    return swing


def _half_range(run: SyntheticRun, joint: str) -> float:
    """Half of how far a joint goes over the run [rad or m]."""
    return max(1e-9, float(np.ptp(run.q[:, run.column(joint)])) / 2)
