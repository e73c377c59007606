"""Faults of single joints: encoders and gears."""

from collections.abc import Iterator
from dataclasses import dataclass
from typing import Annotated, final

import numpy as np

from robolaser.arrays import Array
from robolaser.trials.synthetic.fault_model import Angle, FaultModel, uniform
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


def play_lags(run: SyntheticRun, along: Array, play: float, lag: float) -> Array:
    """The lags of a play operator whose input, (n,), goes straight from pose to pose in the order of time, (n,)."""

    def trailing(lag: float) -> Iterator[float]:
        for move in np.diff(along[run.order], prepend=along[run.order[0]]).tolist():
            lag = play_lag(lag, move, play)
            yield lag

    lags = np.empty(len(along))
    lags[run.order] = [*trailing(lag)]
    return lags


@final
@dataclass(frozen=True)
class ShiftedZero(FaultModel, effect="joint_offset", sizes=(3e-4, 4e-3), signed=True, parameter="offset"):
    """The encoder's zero is off by `size` [rad]."""

    def joints(self, q: Array, run: SyntheticRun) -> Array:
        """Turned on by the error."""
        return turned(q, run.column(self.where), self.size)


@final
@dataclass(frozen=True)
class EncoderGain(FaultModel, effect="encoder_scale", sizes=(3e-4, 4e-3), signed=True, parameter="scale"):
    """The counts of a turn are off by the share `size`."""

    def joints(self, q: Array, run: SyntheticRun) -> Array:
        """Stretched from the zero."""
        column = run.column(self.where)
        return turned(q, column, self.size * q[:, column])


@final
@dataclass(frozen=True)
class OffCentreEncoder(FaultModel, effect="encoder_eccentricity", sizes=(3e-4, 4e-3)):
    """The encoder's disc is off its axis by the share `size` of its radius, by exact geometry."""

    towards: Angle

    def values(self, run: SyntheticRun) -> dict[str, float]:
        """To first order."""
        return {"sine": self.size * np.cos(self.towards), "cosine": -self.size * np.sin(self.towards)}

    def joints(self, q: Array, run: SyntheticRun) -> Array:
        """The angle at the axis when the head beside it reads q."""
        column = run.column(self.where)
        angle = q[:, column] - self.towards
        return turned(q, column, np.arctan2(self.size * np.sin(angle), 1.0 - self.size * np.cos(angle)))


def _ratio(where: str, run: SyntheticRun, rng: np.random.Generator) -> float:
    """Whole for the gears that are sold most, anything for the rest."""
    ratio = float(np.exp(rng.uniform(np.log(10.0), np.log(160.0))))
    return float(round(ratio)) if rng.random() < 0.5 else ratio


@final
@dataclass(frozen=True)
class TransmissionRipple(FaultModel, effect="transmission_error", sizes=(2e-4, 2e-3)):
    """The gear's error repeats once and twice a turn of something that turns `ratio` times as fast as the joint."""

    ratio: Annotated[float, _ratio]
    second: Annotated[float, uniform(0.0, 0.8)]  # the second harmonic over the first
    phases: Annotated[tuple[float, ...], uniform(-np.pi, np.pi, 2)]

    def values(self, run: SyntheticRun) -> dict[str, float]:
        """Of both harmonics."""
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
class LostMotion(FaultModel, effect="backlash", sizes=(3e-4, 3e-3), parameter="lost_motion"):
    """The gear has `size` [rad] of play: the output rests until the input has crossed the gap."""

    began: Annotated[float, uniform(-1.0, 1.0)]  # where in its play

    def joints(self, q: Array, run: SyntheticRun) -> Array:
        """Trailing the input."""
        column = run.column(self.where)
        return turned(q, column, -play_lags(run, q[:, column], self.size, -self.size / 2 * self.began))


@final
@dataclass(frozen=True)
class UncountedTurn(FaultModel, effect="dead_zone", sizes=(4e-4, 4e-3), signed=True, classes=("transmission",)):
    """A dead zone: across some range of a joint an encoder's reading falls behind, by `size` [rad] from end to end."""

    middle: Annotated[float, uniform(0.3, 0.7)]  # in the range of the run
    width: Annotated[float, uniform(0.05, 0.25)]

    def joints(self, q: Array, run: SyntheticRun) -> Array:
        """Behind by half of it on one side, ahead on the other: the zero was set in the middle."""
        column = run.column(self.where)
        read = run.q[:, column]
        share = (read - read.min()) / max(1e-9, float(np.ptp(read)))
        return turned(q, column, self.size * np.clip((share - self.middle) / self.width, -0.5, 0.5))


@final
@dataclass(frozen=True)
class SlippedCoupling(FaultModel, effect="slipping", sizes=(3e-4, 4e-3), signed=True, classes=("transmission",)):
    """A coupling slips at some moment of the run: from there on the joint's zero is off by `size` [rad]."""

    moment: Annotated[float, uniform(0.25, 0.75)]  # as a share of the run

    @classmethod
    def locations(cls, run: SyntheticRun) -> tuple[str, ...]:
        """All but the first and the last, which could as well be the base or the bracket."""
        return run.arm.joints[1:-1]

    def joints(self, q: Array, run: SyntheticRun) -> Array:
        """Off since then."""
        return turned(q, run.column(self.where), np.where(run.share > self.moment, self.size, 0.0))
