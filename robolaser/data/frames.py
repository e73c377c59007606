"""A data set from tables in memory, which have the contents of its files."""

from collections.abc import Iterable, Mapping
from dataclasses import replace
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import Any

from robolaser.data.dataset import Dataset
from robolaser.data.importers.robots import find_robot
from robolaser.data.loading import load
from robolaser.data.writing import csv_text, robot_table, toml_text
from robolaser.errors import DataError, UsageError
from robolaser.robot.kinematics import Robot

FrameColumns = Mapping[str, Iterable[Any]]  # by name: a dictionary of lists or arrays, or a data frame of pandas


def dataset_of_frames(
    poses: FrameColumns,
    points: FrameColumns,
    robot: Robot | str | Path | None,
    flange: str | None,
    tables: Mapping[str, Mapping[str, Any]],
) -> Dataset:
    """See `Dataset.from_frames`; `tables` are those of dataset.toml except the robot's."""
    if flange is not None and (robot is None or isinstance(robot, Robot)):
        raise UsageError(f"flange {flange!r} is of a robot by name or file: state it in `find_robot`, or leave it out.")
    arm = robot if isinstance(robot, Robot) or robot is None else find_robot(robot, flange=flange)
    described = {f"[{table}]" if table else "": values for table, values in tables.items()}
    if arm is not None:
        described["[robot]"] = robot_table(arm)
    of_poses = {column: _column(values) for column, values in poses.items()}
    count = len(next(iter(of_poses.values()), ()))
    texts = {
        "dataset.toml": toml_text(described.items()),
        "poses.csv": _csv({"pose": range(count), **of_poses}, "poses"),
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
        counts = ", ".join(f"{column} {length}" for column, length in lengths.items())
        raise DataError(f"The columns of {name} have different lengths: {counts}.")
    return csv_text(columns.items())
