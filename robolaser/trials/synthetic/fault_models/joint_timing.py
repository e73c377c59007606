"""Joints read at another time than the image, measured before they are at rest, or stopped beside their goal."""

from dataclasses import dataclass
from typing import Annotated, final

import numpy as np

from robolaser.arrays import Array
from robolaser.trials.synthetic.fault_model import FaultModel, uniform
from robolaser.trials.synthetic.fault_models.joints import turned
from robolaser.trials.synthetic.run import SyntheticRun


@final
@dataclass(frozen=True)
class LateExposure(FaultModel, effect="latency", sizes=(3e-4, 8e-3), signed=True):
    """The camera exposes `size` [s] after the reading, while the arm moves on and brakes."""

    braking: Annotated[float, uniform(0.01, 0.1)]  # time constant [s]

    @classmethod
    def locations(cls, run: SyntheticRun) -> tuple[str, ...]:
        """Between controller and camera; in an arm at rest it changes nothing."""
        return ("timing",) if run.qd.any() else ()

    def values(self, run: SyntheticRun) -> dict[str, float]:
        """The delay of an arm that does not brake."""
        return {"delay": float(-np.sign(self.size) * self.braking * np.expm1(-abs(self.size) / self.braking))}

    def joints(self, q: Array, run: SyntheticRun) -> Array:
        """Where the arm was when the shutter opened."""
        return np.asarray(q + run.qd * self.values(run)["delay"])


@final
@dataclass(frozen=True)
class LateArrival(FaultModel, effect="settling", sizes=(2e-4, 4e-3), signed=True):
    """The joint creeps towards its goal and is measured before it is there, sooner at some poses than at others."""

    waits: Annotated[float, uniform(4.0, 8.0)]  # at the poses, in time constants

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


def _beside(where: str, run: SyntheticRun, rng: np.random.Generator) -> Array:
    """Errors of the joints over their RMS size, some larger than others, (n, j)."""
    off = np.zeros(run.q.shape)
    columns = list(run.arm.columns)
    off[:, columns] = rng.normal(size=(len(run.q), len(columns))) * rng.uniform(0.3, 1.7, len(columns))
    return np.asarray(off / np.sqrt(np.square(off[:, columns]).mean()))


@final
@dataclass(frozen=True)
class PoseScatter(FaultModel, sizes=(2e-5, 1e-4), location="arm"):
    """Joints stop beside their goals, the flange by `size` [m] (RMS): noise, which the truth does not name."""

    off: Annotated[Array, _beside]

    def sigma(self, run: SyntheticRun) -> float:
        """RMS error of a joint [rad]."""
        levers = run.arm.levers(run.q)
        return self.size / float(np.sqrt(np.square(levers).sum(axis=(1, 2)).mean()))

    def joints(self, q: Array, run: SyntheticRun) -> Array:
        """Where they stopped."""
        return q + self.sigma(run) * self.off
