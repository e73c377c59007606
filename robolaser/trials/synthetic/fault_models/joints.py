"""Faults of joints: encoders, gears, compliance, timing, and forces from outside."""

from dataclasses import dataclass
from typing import Any, ClassVar, final

import numpy as np

from robolaser.arrays import Array
from robolaser.trials.synthetic.fault_model import FaultModel
from robolaser.trials.synthetic.run import SyntheticRun

LEAST_SWING_NM = 0.2  # of the torque over the run
ALIKE = 0.98  # correlation of the torques with and without payload
WRIST = 3  # joints


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


@final
@dataclass(frozen=True)
class GearWindup(FaultModel):
    """The joint gives way under all that it carries, payload and all: less for each further newton metre."""

    effect: ClassVar[str] = "joint_compliance"
    sizes: ClassVar[tuple[float, float]] = (2e-4, 2.5e-3)

    hardening: float

    @classmethod
    def sample_form(cls, where: str, run: SyntheticRun, rng: np.random.Generator) -> tuple[Any, ...]:
        """How much it stiffens."""
        return (rng.uniform(0.0, 0.3),)

    @classmethod
    def locations(cls, run: SyntheticRun) -> tuple[str, ...]:
        """Joints whose torque from the URDF's masses alone goes with the whole torque: no other can be named."""
        whole = run.arm.torques(run.q, run.payload_kg)
        masses = run.arm.torques(run.q, 0.0)
        alike = [
            np.corrcoef(*pair)[0, 1] if min(np.ptp(pair, axis=1)) > LEAST_SWING_NM else 0.0
            for pair in zip(whole.T, masses.T, strict=True)
        ]
        return tuple(joint for joint in run.arm.joints if alike[run.column(joint)] > ALIKE)

    def joints(self, q: Array, run: SyntheticRun) -> Array:
        """Sunk, by `size` [rad] under the largest torque of the run."""
        column = run.column(self.where)
        torque = run.arm.torques(run.q, run.payload_kg)[:, column]
        load = torque / max(1e-9, float(np.abs(torque).max()))
        return turned(q, column, -self.size * load * (1.0 + self.hardening) / (1.0 + self.hardening * np.abs(load)))


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

    def joints(self, q: Array, run: SyntheticRun) -> Array:
        """Where the arm was when the shutter opened."""
        waited = -self.braking * np.expm1(-abs(self.size) / self.braking)
        moved: Array = q + run.qd * np.sign(self.size) * waited
        return moved


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

    def joints(self, q: Array, run: SyntheticRun) -> Array:
        """Turned on by up to `size` [rad] across half the other's range."""
        swing = _swing(run, self.other)
        return turned(q, run.column(self.where), self.size * (swing - self.homed + 0.03 * np.sin(5.0 * swing)))


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


@final
@dataclass(frozen=True)
class CableForce(FaultModel):
    """A cable, a spring from the ceiling to the flange, turns the wrist; the library has no such effect."""

    effect: ClassVar[str] = "hose"
    sizes: ClassVar[tuple[float, float]] = (5e-4, 4e-3)
    classes: ClassVar[tuple[str, ...]] = ("elasticity", "transmission")

    anchor: tuple[float, float, float]
    slack: float

    @classmethod
    def sample_form(cls, where: str, run: SyntheticRun, rng: np.random.Generator) -> tuple[Any, ...]:
        """Where it hangs, and how long it is [m]."""
        anchor = run.middle + rng.uniform(-1, 1, 3) * [0.6, 0.6, 0.2] + [0.0, 0.0, 1.2]
        return tuple(anchor.tolist()), rng.uniform(0.1, 0.5)

    @classmethod
    def locations(cls, run: SyntheticRun) -> tuple[str, ...]:
        """It is laid along the whole wrist; the truth names the last joint but one."""
        return run.arm.joints[-2:-1]

    def joints(self, q: Array, run: SyntheticRun) -> Array:
        """The wrist's joints turned by the force against their stiffness, at most by `size` [rad]."""
        away = np.array(self.anchor) - run.arm.forward(q)[:, :3, 3]
        length = np.linalg.norm(away, axis=1)
        pull = away * (np.maximum(0.0, length - self.slack) / length)[:, None]
        wrist = [run.column(joint) for joint in run.arm.joints[-WRIST:]]
        turn = np.einsum("nij,ni->nj", run.arm.levers(q)[:, :, wrist], pull)
        q = q.copy()
        q[:, wrist] += self.size * turn / np.abs(turn).max()
        return q


def _neighbour(where: str, run: SyntheticRun, rng: np.random.Generator) -> str:
    """A joint at most two joints away."""
    at = run.arm.joints.index(where)
    return str(rng.choice([joint for i, joint in enumerate(run.arm.joints) if abs(i - at) in (1, 2)]))


def _swing(run: SyntheticRun, joint: str) -> Array:
    """Where in its range over the run a joint is, -1 to 1, (n,)."""
    read = run.q[:, run.column(joint)]
    middle, half = (read.max() + read.min()) / 2, max(1e-9, float(np.ptp(read)) / 2)
    swing: Array = (read - middle) / half
    return swing


def _ratio(rng: np.random.Generator) -> float:
    """Whole for the gears that are sold most, anything for the rest."""
    ratio = float(np.exp(rng.uniform(np.log(10.0), np.log(160.0))))
    return float(round(ratio)) if rng.random() < 0.5 else ratio
