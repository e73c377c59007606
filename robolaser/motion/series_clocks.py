"""Clock offsets between commands and readings that differ between series: all joints share the delay."""

from dataclasses import dataclass, replace
from typing import final

import numpy as np
from scipy.special import chdtrc, fdtrc

from robolaser.arrays import Array, Ints
from robolaser.motion.effect import At
from robolaser.motion.effects.servo import CLOCK, ONE_CLOCK_S
from robolaser.motion.evidence import BY_CHANCE, Fitted
from robolaser.motion.log import MotionLog
from robolaser.motion.selection import SelectedEffect

FEWEST_SERIES, FEWEST_JOINTS = 3, 2
OF_LATENESS = 0.25
"""Least spread of the series' delays, relative to the joints' mean delay: a smaller one may come from the model's form,
whose error differs between motions. A judgement."""


@final
@dataclass(frozen=True, eq=False)
class Lateness:
    """Evidence for delays in a joint's readings: residuals, and their derivatives by a delay, at rows of runs (n,)."""

    residual: Array  # [rad]
    slope: Array  # [rad/s]
    run: Ints
    independent: float  # effective sample size of the rows
    late_s: float  # the joint's delay by its model


@final
@dataclass(frozen=True, eq=False)
class SeriesClocks:
    """Differences of each series' clock from the mean of all."""

    runs: Ints  # (r,)
    delay: Array  # (r,) [s]
    deviation: Array  # (r,) [s]
    gained: Array  # mean squares that the delays explain at each joint, (j,)

    @classmethod
    def of(cls, joints: list[Lateness], known: "SeriesClocks | None" = None) -> "SeriesClocks | None":
        """Delays common to all joints; None where the series do not differ, or joints disagree.

        Each joint's delay in a series is one linear step of its model. Their variance between series, common to all
        joints, is compared with the remaining scatter of each joint alone (an F-test). Beside earlier delays the
        remaining ones are returned, however small.
        """
        runs = np.unique(np.concatenate([one.run for one in joints])) if joints else np.empty(0, np.int64)
        if len(runs) < FEWEST_SERIES or len(joints) < FEWEST_JOINTS:
            return None
        step, weight = np.zeros((2, len(joints), len(runs)))
        for j, one in enumerate(joints):
            noise = float(np.mean(one.residual**2)) * len(one.run) / one.independent
            for r, run in enumerate(runs):
                here = one.run == run
                squares = float(one.slope[here] @ one.slope[here])
                if squares > 0.0:
                    step[j, r] = -float(one.slope[here] @ one.residual[here]) / squares
                    weight[j, r] = squares / max(noise, 1e-24)
        seen = (weight > 0.0).any(axis=0)
        runs, step, weight = runs[seen], step[:, seen], weight[:, seen]
        free, left = len(runs) - 1, int((weight > 0.0).sum()) - len(runs) - len(joints) + 1
        if len(runs) < FEWEST_SERIES or left < 1:
            return None
        step -= (weight * step).sum(axis=1, keepdims=True) / np.maximum(weight.sum(axis=1, keepdims=True), 1e-24)
        delay = (weight * step).sum(axis=0) / weight.sum(axis=0)
        common, own = (weight * delay**2).sum(), (weight * (step - delay) ** 2).sum()
        agree = fdtrc(free, left, common / free / max(own / left, 1e-12)) < BY_CHANCE
        spread = float(np.sqrt(np.average(delay**2, weights=weight.sum(axis=0))))
        late = float(np.mean([abs(one.late_s) for one in joints]))
        if known is None and (
            not agree or chdtrc(free, common) > BY_CHANCE or spread < max(ONE_CLOCK_S, OF_LATENESS * late)
        ):
            return None
        gained = [
            sum(float(d**2) * float(np.sum(one.slope[one.run == run] ** 2)) for run, d in zip(runs, delay, strict=True))
            / len(one.run)
            for one in joints
        ]
        return cls(runs, delay, 1.0 / np.sqrt(weight.sum(axis=0)), np.array(gained))

    def corrected(self, log: MotionLog) -> MotionLog:
        """The log with the commands of each series shifted by its delay; rows without a command are not read."""
        command, q = log.command.copy(), log.q.copy()
        for run, delay in zip(self.runs.tolist(), self.delay.tolist(), strict=True):
            rows = log.rows_of_runs[run]
            time = log.time_s[rows]
            q[rows][(time - delay < time[0]) | (time - delay > time[-1])] = np.nan
            for later, sent in zip(command[rows].T, log.command[rows].T, strict=True):
                later[:] = np.interp(time - delay, time, sent)
        return replace(log, command=command, q=q)

    def beside(self, other: "SeriesClocks | None") -> "SeriesClocks":
        """The sum with earlier delays, of the same series or of some of them."""
        if other is None:
            return self
        before = dict(zip(other.runs.tolist(), other.delay.tolist(), strict=True))
        delay = self.delay + [before.get(run, 0.0) for run in self.runs.tolist()]
        return replace(self, delay=delay, gained=self.gained + other.gained)

    def finding(self, log: MotionLog, joints: Ints) -> SelectedEffect:
        """The clock as a finding, with a number for each series."""
        gained = np.zeros(len(log.joints))
        gained[joints] = self.gained
        numbers = {
            log.series[run]: (delay, deviation, "s")
            for run, delay, deviation in zip(
                self.runs.tolist(), self.delay.tolist(), self.deviation.tolist(), strict=True
            )
        }
        without = Fitted((), (), (), float(np.sum((self.delay / self.deviation) ** 2)), gained)
        return SelectedEffect(At(CLOCK, CLOCK.site, 0), 1.0, 0.0, without, (), numbers, gained)
