"""A data set of tables in memory: what the files of a folder would hold."""

import csv
import io
import json
from collections.abc import Iterable, Mapping
from dataclasses import replace
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import Any

from robolaser.data.dataset import Dataset
from robolaser.data.dataset_file import FORMAT
from robolaser.data.importers.robots import find_robot
from robolaser.data.loading import load
from robolaser.errors import DataError
from robolaser.robot.kinematics import Robot

Frame = Mapping[str, Iterable[Any]]
"""Columns by name: a dictionary of lists or arrays, or a data frame of pandas."""


def dataset_of_frames(
    poses: Frame,
    points: Frame,
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
        name: Of the data set.
        tables: Of dataset.toml, such as `noise={"point_m": 3e-5}` or `target={"placed": False}`.

    Raises:
        DataError: A column is missing or has a wrong value, as in a file; columns have different lengths.
        UsageError: There is no such robot.
    """
    arm = robot if isinstance(robot, Robot) or robot is None else find_robot(robot, flange=flange)
    described: dict[str, Mapping[str, Any]] = {**tables, "sensor": {"kind": sensor, **tables.get("sensor", {})}}
    if arm is not None:
        described["robot"] = {"urdf": "robot.urdf", "flange": arm.flange, "joints": list(arm.joints)}
    poses = dict(poses.items())
    count = len(_column(next(iter(poses.values()), ())))
    head = _toml({"format": FORMAT, "name": name})
    texts = {
        "dataset.toml": head + "".join(f"[{table}]\n{_toml(values)}" for table, values in described.items()),
        "poses.csv": _csv({"pose": range(count), **poses}, "poses"),
        "points.csv": _csv(points, "points"),
        **({} if arm is None else {"robot.urdf": arm.urdf}),
    }
    with TemporaryDirectory() as scratch:
        for file, text in texts.items():
            (Path(scratch) / file).write_text(text, encoding="utf-8")
        return replace(load(scratch), folder=None)


def _toml(values: Mapping[str, Any]) -> str:
    return "".join(f"{key} = {json.dumps(value)}\n" for key, value in values.items())


def _column(values: Iterable[Any]) -> list[Any]:
    return [value.item() if hasattr(value, "item") else value for value in values]


def _csv(frame: Frame, name: str) -> str:
    columns = {column: _column(values) for column, values in frame.items()}
    lengths = {column: len(cells) for column, cells in columns.items()}
    if len(set(lengths.values())) > 1:
        told = ", ".join(f"{column} {length}" for column, length in lengths.items())
        raise DataError(f"The columns of {name} have different lengths: {told}.")
    out = io.StringIO()
    table = csv.writer(out, lineterminator="\n")
    table.writerow(columns)
    table.writerows(zip(*columns.values(), strict=True))
    return out.getvalue()
