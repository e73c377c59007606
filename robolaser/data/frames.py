"""A data set of tables in memory: what the files of a folder would hold."""

from collections.abc import Iterable, Mapping
from dataclasses import replace
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import Any

from robolaser.data.dataset import Dataset
from robolaser.data.dataset_file import FORMAT
from robolaser.data.importers.robots import find_robot
from robolaser.data.loading import load
from robolaser.data.writing import csv_text, robot_table, toml_lines
from robolaser.errors import DataError
from robolaser.robot.kinematics import Robot

FrameColumns = Mapping[str, Iterable[Any]]
"""Columns by name: a dictionary of lists or arrays, or a data frame of pandas."""


def dataset_of_frames(
    poses: FrameColumns,
    points: FrameColumns,
    *,
    robot: Robot | str | Path | None = None,
    flange: str | None = None,
    sensor: str = "point",
    name: str = "measured",
    **tables: Mapping[str, Any],
) -> Dataset:
    """A data set of columns in memory, checked like files.

    Args:
        poses: The columns of poses.csv; without `pose`, poses are called 0, 1, 2 …
        points: The columns of points.csv.
        robot: The arm: what `find_robot` takes, or its result; None for measured flange poses.
        flange: Frame of a robot's file that carries the sensor.
        sensor: Its kind.
        name: Name of the data set.
        tables: Of dataset.toml, such as `noise={"point_m": 3e-5}` or `target={"placed": False}`.

    Raises:
        DataError: A column is missing or has a wrong value, as in a file; columns have different lengths.
        UsageError: There is no such robot.
    """
    arm = robot if isinstance(robot, Robot) or robot is None else find_robot(robot, flange=flange)
    described: dict[str, Mapping[str, Any]] = {"": {"format": FORMAT, "name": name}, "[sensor]": {"kind": sensor}}
    described |= {f"[{table}]": values for table, values in tables.items()}
    if arm is not None:
        described["[robot]"] = robot_table(arm)
    poses = dict(poses.items())
    count = len(_column(next(iter(poses.values()), ())))
    texts = {
        "dataset.toml": "\n".join(line for table in described.items() for line in toml_lines(*table)),
        "poses.csv": _csv({"pose": range(count), **poses}, "poses"),
        "points.csv": _csv(points, "points"),
        **({} if arm is None else {"robot.urdf": arm.urdf}),
    }
    with TemporaryDirectory() as scratch:
        for file, text in texts.items():
            (Path(scratch) / file).write_text(text, encoding="utf-8")
        return replace(load(scratch), folder=None)


def _column(values: Iterable[Any]) -> list[str]:
    plain = (value.item() if hasattr(value, "item") else value for value in values)
    return ["" if value is None else str(value) for value in plain]


def _csv(frame: FrameColumns, name: str) -> str:
    columns = {column: _column(values) for column, values in frame.items()}
    lengths = {column: len(cells) for column, cells in columns.items()}
    if len(set(lengths.values())) > 1:
        told = ", ".join(f"{column} {length}" for column, length in lengths.items())
        raise DataError(f"The columns of {name} have different lengths: {told}.")
    return csv_text(columns.items())
