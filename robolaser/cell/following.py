"""Motions by setpoints: joints get setpoints at a high rate, and their readings are logged with these."""

from collections.abc import Collection, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import final

import numpy as np

from robolaser.arrays import Array
from robolaser.cell.arm import Arm
from robolaser.cell.clock import LEAST_S, Clock, seconds_for
from robolaser.cell.failures import at_worst, not_settled
from robolaser.data.cell_config import Cell
from robolaser.data.csv_tables import read_table, table_text
from robolaser.data.dataset_file import FORMAT
from robolaser.data.writing import robot_table, toml_text
from robolaser.errors import ArmError
from robolaser.robot.kinematics import Robot

BEHIND = np.deg2rad(15.0)  # largest tracking error: hobby servos lag by up to 10° [rad or m]
LOOK_S = 0.5  # time between two polls for faults
REST_S, PATIENCE_S = 0.4, 3.0
"""A joint that has not moved for the first time is at rest; one that still moves after the second does not settle."""
STEPS = 2.5  # of the encoder: apparent motion of an arm at rest

TABLE = "motion/motion.csv"
LOG_FILES = (TABLE, "motion/dataset.toml", "motion/robot.urdf")


@final
@dataclass(frozen=True, eq=False)
class Tick:
    """One sample of a motion."""

    time_s: float  # on the clock
    command: Array  # last setpoint, (j,) [rad or m]
    q: Array  # reading, (j,) [rad or m]


@final
class SetpointStreamer:
    """Moves an arm straight in joint space, by setpoints that accelerate and decelerate smoothly.

    No joint's setpoint exceeds the speed [rad/s or m/s].

    Raises (every method): ArmError where a joint stays too far behind; NotSettled where it does not come to rest.
    """

    def __init__(self, arm: Arm, robot: Robot, speed: float, clock: Clock, rate_hz: float) -> None:
        self._arm, self._robot, self._speed, self._clock, self._rate_hz = arm, robot, speed, clock, rate_hz
        self._command: Array | None = None
        self._ticks: list[Tick] = []
        self._looked_s = -np.inf

    def taken(self) -> list[Tick]:
        """Samples since the last call."""
        ticks, self._ticks = self._ticks, []
        return ticks

    def move(self, goal: Array, place: str) -> Array:
        """Move to a goal, (j,), which messages call `place`, from the last setpoint or the current position.

        Returns:
            The last reading, (j,): the arm may still be moving.
        """
        start = self._held()
        way = goal - start
        seconds, began = seconds_for(way, self._speed), self._clock.now()
        while True:
            share = min(1.0, (self._clock.now() - began) / seconds)
            q = self._tick(start + way * smooth(share), place)
            if share == 1.0:
                return q

    def rest(self, place: str) -> Array:
        """Hold the last setpoint until the joints are at rest, and return their reading, (j,)."""
        command = self._held()
        began = still = self._clock.now()
        q = before = self._tick(command, place)
        while (now := self._clock.now()) - still < REST_S:
            q = self._tick(command, place)
            moved = np.abs(q - before)
            if (moved > STEPS * self._arm.step).any():
                before, still = q, now
            if now - began > PATIENCE_S:
                raise not_settled(f"At {place}", *at_worst(self._robot, moved, moved))
        return q

    def _held(self) -> Array:
        """The setpoint that the joints hold; at first their current position."""
        if self._command is None:
            self._command = self._arm.read()
            self._arm.start_move(self._command, LEAST_S)
        return self._command

    def _tick(self, command: Array, place: str) -> Array:
        """Read, log the last setpoint, send the new one, and wait for the next period."""
        began = self._clock.now()
        if began - self._looked_s > LOOK_S:
            self._arm.poll_faults()
            self._looked_s = began
        q = self._arm.read()
        self._ticks.append(Tick(self._clock.now(), self._held(), q))
        off = np.abs(q - command)
        if (off > BEHIND).any():
            joint, at, wanted = at_worst(self._robot, off, q, command)
            raise ArmError(
                f"On the way to {place}, {joint} is at {at}, but was commanded to {wanted}: it is"
                " blocked, too weak, or turns the other way. Look for what blocks it, and check [arm] direction and"
                " reference_rad in cell.toml; or state a lower speed_rad_s in [limits]."
            )
        self._arm.follow(command)
        self._command = command
        self._clock.wait(max(0.0, began + 1.0 / self._rate_hz - self._clock.now()))
        return q


@final
class SetpointLog:
    """The motion log of a recording, a separate data set inside it: a series for each pose, with its way and rest."""

    def __init__(self, cell: Cell) -> None:
        self._name, self._robot = cell.description.name, cell.robot
        self._rows: list[list[str]] = []
        self.step_rad: float | None = None  # resolution of readings; None: not known

    def add(self, series: str, ticks: Sequence[Tick]) -> None:
        """Add the motion to a pose."""
        for tick in ticks:
            values = (*tick.command.tolist(), *tick.q.tolist())
            self._rows.append([series, f"{tick.time_s - ticks[0].time_s:.4f}", *(f"{value:.6f}" for value in values)])

    def take_up(self, folder: Path, series: Collection[str]) -> None:
        """Resume the log of a recording, keeping some of its series."""
        if (folder / TABLE).is_file():
            table = read_table(folder / TABLE)
            columns = [table.cells(name) for name in table.columns]
            self._rows = [list(row) for row in zip(*columns, strict=True) if row[0] in series]

    def files(self) -> dict[str, bytes]:
        """Contents of its files, by names in the recording's folder; empty before the first motion."""
        if not self._rows:
            return {}
        columns = [f"{what}_{joint}" for what in ("command", "q") for joint in self._robot.joints]
        described: Mapping[str, Mapping[str, object]] = {
            "": {"format": FORMAT, "name": f"{self._name}, its motions"},
            "[robot]": robot_table(self._robot),
            "[sensor]": {"kind": "motion"},
            "[motion]": {"encoder_step_rad": self.step_rad},
        }
        table = table_text(["series", "time_s", *columns], self._rows)
        contents = (table, toml_text(described.items()), self._robot.urdf)
        return {name: each.encode() for name, each in zip(LOG_FILES, contents, strict=True)}


def smooth(share: float) -> float:
    """Share of the way by share of the time, 0 to 1: a polynomial of fifth degree, at rest at both ends."""
    return share**3 * (10.0 - 15.0 * share + 6.0 * share**2)
