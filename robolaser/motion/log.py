"""A log of a moving arm: commands, encoders and torques along time."""

from collections.abc import Mapping
from dataclasses import dataclass, field, replace
from functools import cached_property
from typing import Any, final

import numpy as np

from robolaser.arrays import Array, Bools, Ints
from robolaser.robot.kinematics import Robot

QUANTITIES = ("command", "q", "qd", "tau", "load")  # quantities of a joint that a log may have
OTHER_UNIT = 5.0
"""Factor to the expected size, or its reciprocal, that suggests another unit of a quantity. A judgement."""
ENCODER_RAD = 2e-5  # noise of a good arm's encoder, where no resolution is stated. A judgement
PAUSE_S = 1.0  # gap between rows [s] from which the arm's motion counts as unknown
HOLE_S, LOST_ROWS = 0.2, 2.5
"""Gap between rows [s], and in usual steps, across which commands are not interpolated. A judgement."""


@final
@dataclass(frozen=True, eq=False)
class MotionLog:
    """Runs of an arm, each without interruption. What was not recorded is NaN."""

    name: str
    robot: Robot
    series: tuple[str, ...]  # names of the runs
    run: Ints  # the run of each row, (n,); rows of one run stand together, in the order of time
    time_s: Array  # from the beginning of each run, (n,) [s]
    command: Array  # of each joint, (n, j) [rad]
    q: Array  # the arm's own encoder, (n, j) [rad]
    qd: Array  # joint velocities as recorded, (n, j) [rad/s]
    tau: Array  # joint torques, (n, j) [Nm or A]
    load: Array  # an encoder behind the gear, (n, j) [rad]
    torque_unit: str = "Nm"
    torque_signed: bool = True
    offset_per_series: bool = False  # encoders' zeros differ from run to run
    encoder_step_rad: float | None = None  # resolution of a reading
    payload_kg: Mapping[str, float] = field(default_factory=dict)  # by run
    notes: Mapping[str, Any] = field(default_factory=dict)  # further keys of [motion]
    source: str = ""
    licence: str = ""
    warnings: tuple[str, ...] = ()

    kind = "motion"

    def __len__(self) -> int:
        return len(self.time_s)

    def __repr__(self) -> str:
        """A short description."""
        return (
            f"<MotionLog {self.name}: robot {self.robot.name}, {len(self)} rows in {len(self.series)} series"
            f" of {len(self.joints)} joints>"
        )

    @property
    def joints(self) -> tuple[str, ...]:
        """Names of the joints, in the order of the columns."""
        return self.robot.joints

    @cached_property
    def rows_of_runs(self) -> tuple[slice, ...]:
        """The rows of each run."""
        return self._between(np.inf)

    @cached_property
    def has_signs(self) -> bool:
        """Whether torques have a sign: the log does not deny it, and of several joints some are negative."""
        tau = self.tau[:, self.has("tau")]
        return self.torque_signed and (tau.shape[1] < 2 or bool(np.nanmin(tau) < 0.0 or np.nanmax(tau) <= 0.0))

    @cached_property
    def stretches(self) -> tuple[slice, ...]:
        """The rows of each run, or of its parts between pauses."""
        return self._between(PAUSE_S)

    @cached_property
    def pieces(self) -> tuple[slice, ...]:
        """The same between all gaps across which commands cannot be interpolated."""
        return self._between(self._hole_s)

    def _between(self, most_s: float) -> tuple[slice, ...]:
        ends = np.flatnonzero((np.diff(self.run) != 0) | (np.diff(self.time_s) > most_s)) + 1
        return tuple(slice(start, end) for start, end in zip([0, *ends], [*ends, len(self)], strict=True))

    @property
    def _hole_s(self) -> float:
        return max(HOLE_S, LOST_ROWS * self.step_s)

    @cached_property
    def step_s(self) -> float:
        """The usual time from row to row [s]."""
        steps = np.diff(self.time_s)[np.diff(self.run) == 0]
        return float(np.median(steps)) if len(steps) else 0.0

    def evened(self) -> tuple["MotionLog", Ints]:
        """The same with rows in place of lost ones, and the indices of the recorded rows in it, (n,).

        Missing commands are interpolated; readings there are not compared with them.
        """
        steps = np.diff(self.time_s)[np.diff(self.run) == 0]
        usual = max(float(np.quantile(steps, 0.25)), self.step_s / 4.0, 1e-4) if len(steps) else 1.0
        steps = np.where((np.diff(self.run) == 0) & (np.diff(self.time_s) <= self._hole_s), np.diff(self.time_s), 0.0)
        lost = np.maximum(np.round(steps / usual) - 1.0, 0.0)
        place = np.arange(len(self)) + np.concatenate([[0], np.cumsum(lost)]).astype(np.int64)
        row = np.interp(np.arange(place[-1] + 1), place, np.arange(len(self)))
        there = np.floor(row).astype(np.int64)
        arrays: dict[str, Any] = {name: np.full((len(row), len(self.joints)), np.nan) for name in QUANTITIES}
        for name in QUANTITIES:
            arrays[name][place] = getattr(self, name)
        time_s = np.interp(row, np.arange(len(self)), self.time_s)
        log = replace(self, run=self.run[there], time_s=time_s, **arrays)
        for rows in log.pieces:
            time = time_s[rows]
            for command, read in zip(arrays["command"][rows].T, arrays["q"][rows].T, strict=True):
                known = np.isfinite(command)
                read[~known] = np.nan
                if known.any():
                    command[:] = np.interp(time, time[known], command[known])
        return log, place

    @cached_property
    def as_read(self) -> "MotionLog":
        """The same without readings that only repeat the row above while their joint moves: these are older."""
        return self.less_repeated("q", "tau", "load")

    def less_repeated(self, *quantities: str) -> "MotionLog":
        """The same without values of some quantities that only repeat the row above while these change."""
        arrays = {name: getattr(self, name).copy() for name in quantities}
        for values in arrays.values():
            for column in values.T:
                column[_repeated(column, self.run)] = np.nan
        return replace(self, **arrays)

    def has(self, quantity: str) -> Bools:
        """Which joints have a quantity in more than one row, (j,)."""
        return np.asarray(np.isfinite(getattr(self, quantity)).sum(axis=0) > 1)

    def of_rows(self, chosen: Bools) -> "MotionLog":
        """The log of the chosen rows, (n,), without runs that have none of them."""
        left, run = np.unique(self.run[chosen], return_inverse=True)
        arrays = {name: getattr(self, name)[chosen] for name in (*QUANTITIES, "time_s")}
        return replace(self, series=tuple(self.series[i] for i in left), run=run.astype(np.int64), **arrays)


def _repeated(values: Array, run: Ints) -> Bools:
    """Which values (n,) only repeat the row above, (n,): none, unless most are between two large jumps.

    Rounded readings of a slow joint repeat, too, but not between jumps that are larger than most; so do those of
    a joint that sticks and slips, but not for the same number of rows.
    """
    first = np.flatnonzero(np.append(True, (values[1:] != values[:-1]) | (run[1:] != run[:-1])))
    jumps = np.abs(np.diff(values[first]))
    large = jumps > np.median(np.append(np.nan_to_num(jumps), 0.0))
    between = np.concatenate([[False], large[1:] & large[:-1], [False]])
    length = np.diff(np.append(first, len(values)))
    low, usual, high = np.quantile(length[between], (0.05, 0.5, 0.95)) if between.any() else (1, 1, 1)
    is_held = usual > 1.0 and high - low <= 2.0
    out = np.repeat((length > 1) & (length <= 2.0 * usual) & is_held, length)
    out[first] = False
    return out


def filled(values: Array) -> Array:
    """Values with gaps filled by the last value before them, or else the first, (n, j)."""
    if np.isfinite(values).all():
        return values
    out = values.copy()
    for column in out.T:
        known = np.flatnonzero(np.isfinite(column))
        if len(known):
            last = np.maximum.accumulate(np.where(np.isfinite(column), np.arange(len(column)), -1))
            column[:] = column[np.where(last >= 0, last, known[0])]
    return out
