"""Faults of joints: encoders, gears, coupling with other joints, and times of reading and rest."""

from abc import abstractmethod
from itertools import accumulate
from typing import Annotated, final

import numpy as np

from robolaser.arrays import Array
from robolaser.trials.synthetic.fault_model import Angle, Coin, FaultModel, SyntheticRun, uniform


def turned(q: Array, column: int, by: Array | float) -> Array:
    """The same joint angles but for one joint, (n, j) [rad or m]."""
    q = q.copy()
    q[:, column] += by
    return q


def play_lags(run: SyntheticRun, along: Array, play: float, lag: float) -> Array:
    """The lags of a play operator whose input, (n,), goes straight from pose to pose in the order of time, (n,).

    The lag of its output is between minus and plus half the play: Visintin, Differential Models of Hysteresis,
    1994, chapter III.
    """
    moves = np.diff(along[run.order], prepend=along[run.order[0]]).tolist()
    trailing = accumulate(moves, lambda lag, move: min(max(lag + move, -play / 2), play / 2), initial=lag)
    lags = np.empty(len(along))
    lags[run.order] = [*trailing][1:]
    return lags


@final
class ShiftedZero(FaultModel, effect="joint_offset", sizes=(3e-4, 4e-3), signed=True, parameter="offset"):
    """The encoder's zero is off by `size` [rad]."""

    def joints(self, q: Array, run: SyntheticRun) -> Array:
        return turned(q, run.column(self.where), self.size)


@final
class EncoderGain(FaultModel, effect="encoder_scale", sizes=(3e-4, 4e-3), signed=True, parameter="scale"):
    """The counts of a turn are off by the share `size`."""

    def joints(self, q: Array, run: SyntheticRun) -> Array:
        column = run.column(self.where)
        return turned(q, column, self.size * q[:, column])


@final
class OffCentreEncoder(FaultModel, effect="encoder_eccentricity", sizes=(3e-4, 4e-3)):
    """The encoder's disc is off its axis by the share `size` of its radius, by exact geometry."""

    towards: Angle

    def values(self, run: SyntheticRun) -> dict[str, float]:
        """To first order."""
        return {"sine": self.size * np.cos(self.towards), "cosine": -self.size * np.sin(self.towards)}

    def joints(self, q: Array, run: SyntheticRun) -> Array:
        """The angle at the axis for a reading q of the off-axis head."""
        column = run.column(self.where)
        angle = q[:, column] - self.towards
        return turned(q, column, np.arctan2(self.size * np.sin(angle), 1.0 - self.size * np.cos(angle)))


def _ratio(where: str, run: SyntheticRun, rng: np.random.Generator) -> float:
    """A gear ratio: whole for the most common gears, any number for others."""
    ratio = float(np.exp(rng.uniform(np.log(10.0), np.log(160.0))))
    return float(round(ratio)) if rng.random() < 0.5 else ratio


@final
class TransmissionRipple(FaultModel, effect="transmission_error", sizes=(2e-4, 2e-3)):
    """The gear's error repeats once and twice a turn of a part that turns `ratio` times as fast as the joint."""

    ratio: Annotated[float, _ratio]
    second: Annotated[float, uniform(0.0, 0.8)]  # the second harmonic over the first
    phases: Annotated[tuple[float, ...], uniform(-np.pi, np.pi, 2)]

    def values(self, run: SyntheticRun) -> dict[str, float]:
        once, twice = (np.array([np.cos(phase), np.sin(phase)]) * self.size for phase in self.phases)
        names = ("sine", "cosine", "sine_2", "cosine_2", "cycles")
        return dict(zip(names, (*once.tolist(), *(self.second * twice).tolist(), self.ratio), strict=True))

    def joints(self, q: Array, run: SyntheticRun) -> Array:
        column = run.column(self.where)
        motor = self.ratio * q[:, column]
        once, twice = (np.sin((i + 1) * motor + phase) for i, phase in enumerate(self.phases))
        return turned(q, column, self.size * (once + self.second * twice))


@final
class LostMotion(FaultModel, effect="backlash", sizes=(3e-4, 3e-3), parameter="lost_motion"):
    """The gear has `size` [rad] of play: the output rests until the input has crossed the gap."""

    began: Annotated[float, uniform(-1.0, 1.0)]  # initial position in its play

    def joints(self, q: Array, run: SyntheticRun) -> Array:
        column = run.column(self.where)
        return turned(q, column, -play_lags(run, q[:, column], self.size, -self.size / 2 * self.began))


@final
class UncountedTurn(FaultModel, effect="dead_zone", sizes=(4e-4, 4e-3), signed=True, classes=("transmission",)):
    """A dead zone: over some range of a joint, the encoder's reading loses `size` [rad] from end to end."""

    middle: Annotated[float, uniform(0.3, 0.7)]  # in the range of the run
    width: Annotated[float, uniform(0.05, 0.25)]

    def joints(self, q: Array, run: SyntheticRun) -> Array:
        """Half of it behind on one side, half ahead on the other: the zero was set in the middle."""
        column = run.column(self.where)
        read = run.q[:, column]
        share = (read - read.min()) / max(1e-9, float(np.ptp(read)))
        return turned(q, column, self.size * np.clip((share - self.middle) / self.width, -0.5, 0.5))


@final
class SlippedCoupling(
    FaultModel,
    effect="slipping",
    sizes=(3e-4, 4e-3),
    signed=True,
    places=lambda run: run.joints[1:-1],
    classes=("transmission",),
):
    """A coupling slips at some instant of the run: from then on the joint's zero is off by `size` [rad].

    At the first joint the base is equivalent, at the last the bracket.
    """

    moment: Annotated[float, uniform(0.25, 0.75)]  # as a share of the run

    def joints(self, q: Array, run: SyntheticRun) -> Array:
        return turned(q, run.column(self.where), np.where(run.share > self.moment, self.size, 0.0))


def _neighbour(where: str, run: SyntheticRun, rng: np.random.Generator) -> str:
    """A joint at most two joints away."""
    at = run.joints.index(where)
    return str(rng.choice([joint for i, joint in enumerate(run.joints) if abs(i - at) in (1, 2)]))


class Coupling(FaultModel, places=lambda run: run.joints if len(run.joints) > 1 else ()):
    """Another joint turns this one."""

    other: Annotated[str, _neighbour]

    def sites(self, run: SyntheticRun) -> tuple[str, ...]:
        return self.where, self.other

    def joints(self, q: Array, run: SyntheticRun) -> Array:
        """Turned on by the other joint's position in its range over the run, -1 to 1."""
        middle, half = self._range(run)
        swing: Array = (run.q[:, run.column(self.other)] - middle) / half
        return turned(q, run.column(self.where), self.size * self.share(swing))

    @abstractmethod
    def share(self, swing: Array) -> Array:
        """Share of the size by which it turns, (n,)."""

    def _range(self, run: SyntheticRun) -> tuple[float, float]:
        """The middle of the other joint's range, and half of its length [rad or m]."""
        read = run.q[:, run.column(self.other)]
        return float(read.max() + read.min()) / 2, max(1e-9, float(np.ptp(read))) / 2


@final
class LedAlong(Coupling, effect="joint_coupling", sizes=(4e-4, 4e-3), signed=True):
    """A belt runs along another joint, whose motion turns this one, with a little ripple of its pulley."""

    homed: Annotated[float, uniform(-1.0, 1.0)]  # position in its range at which both were homed

    def values(self, run: SyntheticRun) -> dict[str, float]:
        """Those of a belt without ripple."""
        middle, half = self._range(run)
        ratio, homed = self.size / half, middle + self.homed * half
        return {"ratio": ratio, "offset": -ratio * homed, "other": 1.0 + run.joints.index(self.other)}

    def share(self, swing: Array) -> Array:
        """All of it across half the other's range."""
        return swing - self.homed + 0.03 * np.sin(5.0 * swing)


@final
class CrossTalk(
    Coupling, effect="cross_talk", sizes=(4e-4, 4e-3), classes=("transmission",), also=(("joint_coupling", None),)
):
    """Another joint turns this one, but not in proportion to its angle; the library has no such effect."""

    even: Coin

    def share(self, swing: Array) -> Array:
        return swing**2 if self.even else np.sin(np.pi * swing)


@final
class LateExposure(
    FaultModel,
    effect="latency",
    sizes=(3e-4, 8e-3),
    signed=True,
    places=lambda run: ("timing",) if run.qd.any() else (),
):
    """The camera exposes `size` [s] after the reading, while the arm moves on and brakes; one at rest stays."""

    braking: Annotated[float, uniform(0.01, 0.1)]  # time constant [s]

    def values(self, run: SyntheticRun) -> dict[str, float]:
        """The delay of an arm that does not brake."""
        return {"delay": float(-np.sign(self.size) * self.braking * np.expm1(-abs(self.size) / self.braking))}

    def joints(self, q: Array, run: SyntheticRun) -> Array:
        return np.asarray(q + run.qd * self.values(run)["delay"])


@final
class LateArrival(FaultModel, effect="settling", sizes=(2e-4, 4e-3), signed=True):
    """The joint creeps towards its goal and is measured before it is there, sooner at some poses than at others."""

    waits: Annotated[float, uniform(4.0, 8.0)]  # at the poses, in time constants

    def joints(self, q: Array, run: SyntheticRun) -> Array:
        """Short of its goal by a share `size` of the way from its previous position, at the middle one of the waits."""
        column, order = run.column(self.where), run.order
        pause = np.diff(run.time[order], prepend=run.time[order][0])
        usual = float(np.median(pause[1:]))
        shares = self.size * np.exp(-0.1 * self.waits * (pause / usual - 1.0))
        short = np.zeros(len(q))
        for i in range(1, len(order)):
            before = q[order[i - 1], column] - short[order[i - 1]]
            short[order[i]] = shares[i] * (q[order[i], column] - before)
        return turned(q, column, -short)


def _beside(where: str, run: SyntheticRun, rng: np.random.Generator) -> Array:
    """Errors of the joints over their RMS size, some larger than others, (n, j)."""
    off = np.zeros(run.q.shape)
    columns = list(run.arm.columns)
    off[:, columns] = rng.normal(size=(len(run.q), len(columns))) * rng.uniform(0.3, 1.7, len(columns))
    return np.asarray(off / np.sqrt(np.square(off[:, columns]).mean()))


@final
class PoseScatter(FaultModel, sizes=(2e-5, 1e-4), location="arm"):
    """Joints stop off their goals, the flange by `size` [m] (RMS): noise, which the truth does not name."""

    off: Annotated[Array, _beside]

    def sigma(self, run: SyntheticRun) -> float:
        """RMS error of a joint [rad]."""
        return self.size / float(np.sqrt(np.square(run.arm.levers(run.q)).sum(axis=(1, 2)).mean()))

    def joints(self, q: Array, run: SyntheticRun) -> Array:
        return q + self.sigma(run) * self.off
