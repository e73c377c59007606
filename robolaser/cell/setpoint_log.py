"""The motion log of a recording, a data set of its own below it: setpoints beside what the joints read."""

import json
from collections.abc import Collection, Sequence
from pathlib import Path
from typing import Final, final

from robolaser.cell.following import Tick
from robolaser.data.cell_config import Cell
from robolaser.data.csv_tables import read_table, table_text
from robolaser.robot.kinematics import Robot

FOLDER: Final = "motion"
TABLE: Final = f"{FOLDER}/motion.csv"
FILES: Final = (TABLE, f"{FOLDER}/dataset.toml", f"{FOLDER}/robot.urdf")


@final
class SetpointLog:
    """A series for each pose: the way there, and the rest before its images are taken."""

    def __init__(self, cell: Cell) -> None:
        self._name, self._robot = cell.description.name, cell.robot
        self._rows: list[list[str]] = []
        self.step_rad: float | None = None
        """What readings are rounded to; None: not known."""

    def add(self, series: str, ticks: Sequence[Tick]) -> None:
        """Note the motion to a pose."""
        for tick in ticks:
            values = (*tick.command.tolist(), *tick.q.tolist())
            self._rows.append([series, f"{tick.time_s - ticks[0].time_s:.4f}", *(f"{value:.6f}" for value in values)])

    def take_up(self, folder: Path, series: Collection[str]) -> None:
        """Go on with the log of a recording, of which some series are kept."""
        if (folder / TABLE).is_file():
            table = read_table(folder / TABLE)
            columns = [table.cells(name) for name in table.columns]
            self._rows = [list(row) for row in zip(*columns, strict=True) if row[0] in series]

    def files(self) -> dict[str, bytes]:
        """What its files hold, by their names in the recording's folder; none before the first motion."""
        if not self._rows:
            return {}
        columns = [f"{what}_{joint}" for what in ("command", "q") for joint in self._robot.joints]
        text = table_text(["series", "time_s", *columns], self._rows)
        contents = (text, _settings(self._name, self._robot, self.step_rad), self._robot.urdf)
        return {name: each.encode() for name, each in zip(FILES, contents, strict=True)}


def _settings(name: str, robot: Robot, step_rad: float | None) -> str:
    rounded = "" if step_rad is None else f"\n[motion]\nencoder_step_rad = {step_rad!r}\n"
    return f"""\
format = "robolaser-dataset/1"
name = {json.dumps(f"{name}, its motions")}

[robot]
urdf = "robot.urdf"
flange = {json.dumps(robot.flange)}
joints = {json.dumps(list(robot.joints))}
gravity = {list(robot.gravity)}

[sensor]
kind = "motion"
{rounded}"""
