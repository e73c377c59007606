"""Faults of single joints: encoders and gears."""

from dataclasses import dataclass
from typing import Any, ClassVar, final

import numpy as np

from robolaser.arrays import Array
from robolaser.trials.synthetic.fault_model import FaultModel
from robolaser.trials.synthetic.run import SyntheticRun


def turned(q: Array, column: int, by: Array | float) -> Array:
    """The same joint angles but for one joint, (n, j) [rad or m]."""
    q = q.copy()
    q[:, column] += by
    return q


def play_lag(lag: float, move: float, play: float) -> float:
    """How far the output of a play operator trails its input after a move of the input [rad].

    Visintin, Differential Models of Hysteresis, 1994, chapter III.

    Args:
        lag: Before the move, between minus and plus half the play.
        move: Of the input.
        play: The whole of it.
    """
    return min(max(lag + move, -play / 2), play / 2)


@final
@dataclass(frozen=True)
class ShiftedZero(FaultModel):
    """The encoder's zero is off by `size` [rad]."""

    effect: ClassVar[str] = "joint_offset"
    sizes: ClassVar[tuple[float, float]] = (3e-4, 4e-3)
    signed: ClassVar[bool] = True

    def values(self, run: SyntheticRun) -> dict[str, float]:
        """Of the library's number."""
        return {"offset": self.size}

    def joints(self, q: Array, run: SyntheticRun) -> Array:
        """Turned on by the error."""
        return turned(q, run.column(self.where), self.size)


@final
@dataclass(frozen=True)
class EncoderGain(FaultModel):
    """The counts of a turn are off by the share `size`."""

    effect: ClassVar[str] = "encoder_scale"
    sizes: ClassVar[tuple[float, float]] = (3e-4, 4e-3)
    signed: ClassVar[bool] = True

    def values(self, run: SyntheticRun) -> dict[str, float]:
        """Of the library's number."""
        return {"scale": self.size}

    def joints(self, q: Array, run: SyntheticRun) -> Array:
        """Stretched from the zero."""
        column = run.column(self.where)
        return turned(q, column, self.size * q[:, column])


@final
@dataclass(frozen=True)
class OffCentreEncoder(FaultModel):
    """The encoder's disc is off its axis by the share `size` of its radius, towards the angle `towards` [rad].

    By exact geometry, not only in first order.
    """

    effect: ClassVar[str] = "encoder_eccentricity"
    sizes: ClassVar[tuple[float, float]] = (3e-4, 4e-3)

    towards: float

    @classmethod
    def sample_form(cls, where: str, run: SyntheticRun, rng: np.random.Generator) -> tuple[Any, ...]:
        """Any direction."""
        return (rng.uniform(-np.pi, np.pi),)

    def values(self, run: SyntheticRun) -> dict[str, float]:
        """Of the library's numbers."""
        return {"sine": self.size * np.cos(self.towards), "cosine": -self.size * np.sin(self.towards)}

    def joints(self, q: Array, run: SyntheticRun) -> Array:
        """The angle at the axis when the head beside it reads q."""
        column = run.column(self.where)
        angle = q[:, column] - self.towards
        return turned(q, column, np.arctan2(self.size * np.sin(angle), 1.0 - self.size * np.cos(angle)))


@final
@dataclass(frozen=True)
class TransmissionRipple(FaultModel):
    """The gear's error repeats once and twice a turn of something that turns `ratio` times as fast as the joint."""

    effect: ClassVar[str] = "transmission_error"
    sizes: ClassVar[tuple[float, float]] = (2e-4, 2e-3)

    ratio: float
    second: float
    phases: tuple[float, float]

    @classmethod
    def sample_form(cls, where: str, run: SyntheticRun, rng: np.random.Generator) -> tuple[Any, ...]:
        """Two harmonics, in no fixed ratio or phase."""
        return _ratio(rng), rng.uniform(0.0, 0.8), tuple(rng.uniform(-np.pi, np.pi, 2).tolist())

    def values(self, run: SyntheticRun) -> dict[str, float]:
        """Of the library's numbers."""
        once, twice = (np.array([np.cos(phase), np.sin(phase)]) * self.size for phase in self.phases)
        names = ("sine", "cosine", "sine_2", "cosine_2", "cycles")
        return dict(zip(names, (*once.tolist(), *(self.second * twice).tolist(), self.ratio), strict=True))

    def joints(self, q: Array, run: SyntheticRun) -> Array:
        """Off by both harmonics."""
        column = run.column(self.where)
        motor = self.ratio * q[:, column]
        once, twice = (np.sin((i + 1) * motor + phase) for i, phase in enumerate(self.phases))
        return turned(q, column, self.size * (once + self.second * twice))


@final
@dataclass(frozen=True)
class LostMotion(FaultModel):
    """The gear has `size` [rad] of play: the output rests until the input has crossed the gap."""

    effect: ClassVar[str] = "backlash"
    sizes: ClassVar[tuple[float, float]] = (3e-4, 3e-3)

    began: float

    @classmethod
    def sample_form(cls, where: str, run: SyntheticRun, rng: np.random.Generator) -> tuple[Any, ...]:
        """Where in its play it begins."""
        return (rng.uniform(-1.0, 1.0),)

    def values(self, run: SyntheticRun) -> dict[str, float]:
        """Of the library's number."""
        return {"lost_motion": self.size}

    def joints(self, q: Array, run: SyntheticRun) -> Array:
        """Trailing the input, which goes straight from pose to pose in the order of time."""
        column = run.column(self.where)
        lag, lags = -self.size / 2 * self.began, np.empty(len(q))
        angles = q[run.order, column]
        for row, move in zip(run.order, np.diff(angles, prepend=angles[0]), strict=True):
            lags[row] = lag = play_lag(lag, float(move), self.size)
        return turned(q, column, -lags)


def _ratio(rng: np.random.Generator) -> float:
    """Whole for the gears that are sold most, anything for the rest."""
    ratio = float(np.exp(rng.uniform(np.log(10.0), np.log(160.0))))
    return float(round(ratio)) if rng.random() < 0.5 else ratio
