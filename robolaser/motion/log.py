"""A log of a moving arm: commands, encoders and torques along time."""

from collections.abc import Mapping
from dataclasses import dataclass, field, replace
from functools import cached_property
from typing import Any, final

import numpy as np

from robolaser.arrays import Array, Bools, Ints
from robolaser.robot.kinematics import Robot

QUANTITIES = ("command", "q", "qd", "tau", "load")
"""What is recorded of a joint, as far as it is."""
OTHER_UNIT = 5.0
"""Times what is expected, or its reciprocal, from which on a quantity is likely to have another unit. A judgement."""
ENCODER_RAD = 2e-5
"""Noise of a good arm's encoder, where no resolution is stated. A judgement."""
PAUSE_S = 1.0
"""Without rows for so long, nothing is known of what the arm did."""


@final
@dataclass(frozen=True, eq=False)
class MotionLog:
    """Runs of an arm, each without interruption. What was not recorded is NaN."""

    name: str
    robot: Robot
    series: tuple[str, ...]  # names of the runs
    run: Ints  # the run of each row, (n,); rows of one run stand together, in the order of time
    time_s: Array  # from the beginning of each run, (n,) [s]
    command: Array  # what each joint was told, (n, j) [rad]
    q: Array  # the arm's own encoder, (n, j) [rad]
    qd: Array  # joint velocities as recorded, (n, j) [rad/s]
    tau: Array  # joint torques, (n, j) [Nm or A]
    load: Array  # an encoder behind the gear, (n, j) [rad]
    torque_unit: str = "Nm"
    torque_signed: bool = True
    offset_per_series: bool = False  # encoders' zeros differ from run to run
    encoder_step_rad: float | None = None  # what a reading is rounded to
    payload_kg: Mapping[str, float] = field(default_factory=dict)  # by run
    notes: Mapping[str, Any] = field(default_factory=dict)  # further keys of [motion]
    source: str = ""
    licence: str = ""
    warnings: tuple[str, ...] = ()

    kind = "motion"

    def __len__(self) -> int:
        return len(self.time_s)

    def __repr__(self) -> str:
        """In a few words."""
        return (
            f"<MotionLog {self.name}: robot {self.robot.name}, {len(self)} rows in {len(self.series)} series"
            f" of {len(self.joints)} joints>"
        )

    @property
    def joints(self) -> tuple[str, ...]:
        """Names of the joints, in the order of the columns."""
        return self.robot.joints

    @cached_property
    def starts(self) -> Ints:
        """The first row of each run, (runs,)."""
        return np.searchsorted(self.run, np.arange(len(self.series))).astype(np.int64)

    @cached_property
    def rows_of_runs(self) -> tuple[slice, ...]:
        """The rows of each run."""
        ends = [*self.starts[1:].tolist(), len(self)]
        return tuple(slice(start, end) for start, end in zip(self.starts.tolist(), ends, strict=True))

    @cached_property
    def has_signs(self) -> bool:
        """Whether torques have a sign: it is not said that they have none, and of several joints some are negative."""
        several = self.tau[:, self.has("tau")]
        return self.torque_signed and (several.shape[1] < 2 or bool(np.nanmin(several) < 0.0 or not several.any()))

    @cached_property
    def stretches(self) -> tuple[slice, ...]:
        """The rows of each run, or of its parts between pauses."""
        ends = np.flatnonzero((np.diff(self.run) != 0) | (np.diff(self.time_s) > PAUSE_S)) + 1
        return tuple(slice(start, end) for start, end in zip([0, *ends], [*ends, len(self)], strict=True))

    @cached_property
    def step_s(self) -> float:
        """The usual time from row to row [s]."""
        steps = np.diff(self.time_s)[np.diff(self.run) == 0]
        return float(np.median(steps)) if len(steps) else 0.0

    def has(self, quantity: str) -> Bools:
        """Which joints have a quantity in more than one row, (j,)."""
        return np.asarray(np.isfinite(getattr(self, quantity)).sum(axis=0) > 1)

    def of_rows(self, chosen: Bools) -> "MotionLog":
        """The same log with only the chosen rows, (n,); runs that lose all of theirs are gone."""
        left, run = np.unique(self.run[chosen], return_inverse=True)
        arrays = {name: getattr(self, name)[chosen] for name in (*QUANTITIES, "time_s")}
        return replace(self, series=tuple(self.series[i] for i in left), run=run.astype(np.int64), **arrays)


def filled(values: Array) -> Array:
    """Values with gaps filled by the last one before, or else the first, (n, j)."""
    if np.isfinite(values).all():
        return values
    out = values.copy()
    for column in out.T:
        known = np.flatnonzero(np.isfinite(column))
        if len(known):
            last = np.maximum.accumulate(np.where(np.isfinite(column), np.arange(len(column)), -1))
            column[:] = column[np.where(last >= 0, last, known[0])]
    return out
