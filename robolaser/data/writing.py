"""A data set as a folder on disk, which `load` reads back unchanged."""

import json
from collections.abc import Iterable, Iterator, Mapping, Sequence
from dataclasses import asdict
from pathlib import Path

import numpy as np

from robolaser.arrays import Array
from robolaser.data.csv_tables import table_text
from robolaser.data.data_tables import FLANGE_COLUMNS
from robolaser.data.dataset import Dataset
from robolaser.data.dataset_file import FORMAT
from robolaser.data.result_folder import write_results
from robolaser.data.sessions import OWN
from robolaser.errors import UsageError, output_exists
from robolaser.geometry.rigid_motion import to_quaternion
from robolaser.parameters import Parameter
from robolaser.robot.kinematics import DOWN, Robot

FOLDER = ("dataset.toml", "poses.csv", "points.csv", "robot.urdf")  # the files of a data set


def save(dataset: Dataset, folder: str | Path, *, overwrite: bool = False) -> None:
    """Write a data set, completely or not at all; of images, only the paths are written.

    Args:
        dataset: Without points it becomes a recording, which has no points.csv.
        folder: Created if it does not exist.
        overwrite: Replace an existing data set.

    Raises:
        OutputError: There is one, or the folder cannot be written to.
        UsageError: It is no data set with poses.

    Examples:
        >>> robolaser.save(dataset, "saved")
        >>> sorted(path.name for path in Path("saved").glob("[!.]*"))
        ['dataset.toml', 'points.csv', 'poses.csv', 'robot.urdf']
    """
    if not isinstance(dataset, Dataset):
        raise UsageError(f"Expected a data set with poses, not a {type(dataset).__name__}.")
    folder = Path(folder)
    for file in files_of(dataset):
        if not overwrite and (folder / file).exists():
            raise output_exists(folder / file)
    write_results(folder, texts_of(dataset))


def files_of(dataset: Dataset) -> list[str]:
    """Names of all files of a data set."""
    return [*dict.fromkeys((*FOLDER, *(sensor.file for sensor in dataset.sensors)))]


def texts_of(dataset: Dataset) -> dict[str, str | None]:
    """Contents of its files, by name; None where a file does not exist. dataset.toml comes last."""
    has_points = len(dataset.points) > 0
    return {
        **({} if dataset.robot is None else {"robot.urdf": dataset.robot.urdf}),
        "poses.csv": csv_text(pose_columns(dataset)),
        **(point_texts(dataset) if has_points else dict.fromkeys(sensor.file for sensor in dataset.sensors)),
        "dataset.toml": toml_text(_settings(dataset)),
    }


def point_texts(dataset: Dataset) -> dict[str, str | None]:
    """Contents of points.csv, or that of each of several sensors, by name."""
    return {sensor.file: csv_text(point_columns(sensor.data)) for sensor in dataset.sensors}


def csv_text(columns: Iterable[tuple[str, Sequence[str]]]) -> str:
    """A table of columns by name."""
    named = dict(columns)
    return table_text(list(named), zip(*named.values(), strict=True))


def _digits(values: Array) -> list[str]:
    """The shortest texts that read back as the same numbers."""
    return [repr(float(value)) for value in values]


def _spread(names: Sequence[str], values: Array) -> Iterator[tuple[str, Sequence[str]]]:
    yield from ((name, _digits(values[:, i])) for i, name in enumerate(names))


def pose_columns(dataset: Dataset) -> Iterator[tuple[str, Sequence[str]]]:
    """The columns of poses.csv, as they are written."""
    poses, robot = dataset.poses, dataset.robot
    yield "pose", poses.names
    if poses.time_s is not None:
        yield "time_s", _digits(poses.time_s)
    if robot is not None and poses.q is not None:
        yield from _spread([f"q_{joint}" for joint in robot.joints], poses.q)
        if poses.qd is not None and not poses.qd_from_path:
            yield from _spread([f"qd_{joint}" for joint in robot.joints], poses.qd)
    if robot is None and poses.T_base_flange is not None:
        T = poses.T_base_flange
        yield from _spread(FLANGE_COLUMNS[:3], T[:, :3, 3])
        yield from _spread(FLANGE_COLUMNS[3:], to_quaternion(T[:, :3, :3]))
    if poses.image is not None:
        yield "image", poses.image
    for column, values in (("payload_kg", poses.payload_kg), ("temperature_c", poses.temperature_c)):
        if values is not None:
            yield column, _digits(values)
    if poses.session is not None:
        yield "session", poses.session
    yield from poses.extra.items()


def point_columns(dataset: Dataset) -> Iterator[tuple[str, Sequence[str]]]:
    """The columns of points.csv, as they are written."""
    points = dataset.points
    yield "pose", [dataset.poses.names[i] for i in points.pose]
    yield "point", points.names
    if points.repeat is not None:
        yield "repeat", [str(shot) for shot in points.repeat]
    for name, columns in dataset.format.columns.items():
        yield from _spread(columns, points[name])


def _settings(dataset: Dataset) -> Iterator[tuple[str, Mapping[str, object]]]:
    """The tables of dataset.toml."""
    own = None if dataset.sessions is None or dataset.sessions.own == OWN else dataset.sessions.own
    yield "", {"format": FORMAT, "name": dataset.name, "source": dataset.source, "licence": dataset.licence}
    path = {"time": "order" if dataset.time_is_order else None, "path": None if dataset.path_known else "unknown"}
    yield "[robot]", (robot_table(dataset.robot) if dataset.robot else {}) | path
    header, within = ("[[sensors]]", "sensors.") if dataset.members else ("[sensor]", "")
    for sensor in dataset.members or dataset.sensors:
        named = {"name": sensor.name, "points": sensor.file, "camera": sensor.camera} if dataset.members else {}
        named |= {} if sensor.target in ("target", "") else {"target": sensor.target}
        yield header, {**named, **_sensor(sensor.data)}
        own_tables = _tables(sensor.data).items()
        yield from ((f"[{within}{table}]", values) for table, values in own_tables if table not in named)
    for member in [one for one in dataset.members if one.target != "target"][:1]:  # its key `target` is the name
        yield "[target]", _tables(member.data)["target"]
    yield "[sessions]", {"own": None if own is None else list(own)}
    yield "[parameters]", {name: _parameter(item) for name, item in dataset.parameters.items()}


def toml_text(tables: Iterable[tuple[str, Mapping[str, object]]]) -> str:
    """A TOML file of tables by their headers, the first may be ""; without empty tables and keys."""
    written = []
    for header, values in tables:
        lines = [
            f"{_key(key)} = {_value(value)}"
            for key, value in values.items()
            if not (value is None or (isinstance(value, str | tuple | dict) and not value))
        ]
        if lines:
            written.append("\n".join([header, *lines] if header else lines))
    return "\n\n".join(written) + "\n"


def _parameter(item: Parameter) -> dict[str, object]:
    bounds = {"fixed": True} if item.fixed else {"lower": item.lower, "upper": item.upper}
    return {"nominal": item.nominal, **bounds}


def _sensor(dataset: Dataset) -> Mapping[str, object]:
    if dataset.options is not None:
        return {"kind": dataset.kind, **asdict(dataset.options)}
    return {"kind": dataset.kind} | ({"stripe_axis": dataset.stripe_axis} if _has_scanner(dataset) else {})


def _tables(dataset: Dataset) -> dict[str, Mapping[str, object]]:
    """Keys of a sensor other than its kind."""
    scanner: dict[str, object] = {"bracket_quat": dataset.bracket_quat, "angles": dataset.angles}
    return {
        "scanner": scanner if _has_scanner(dataset) else {},
        "image": dict(zip(("width_px", "height_px"), dataset.image_px or (), strict=False)),
        "board": {} if dataset.board is None else asdict(dataset.board),
        "target": {"placed": dataset.placed, "distances_m": dataset.distances_m, "radius_m": dict(dataset.radius_m)},
        "noise": asdict(dataset.noise),
    }


def _has_scanner(dataset: Dataset) -> bool:
    return "scanner" in dataset.format.tables


def robot_table(robot: Robot) -> dict[str, object]:
    """The table `[robot]` of an arm whose URDF is in the same folder."""
    gravity = None if robot.gravity == DOWN else robot.gravity
    return {"urdf": "robot.urdf", "flange": robot.flange, "joints": robot.joints, "gravity": gravity}


def _key(name: str) -> str:
    return name if name.isascii() and name.replace("_", "a").replace("-", "a").isalnum() else _text(name)


def _text(text: str) -> str:
    """A TOML string: JSON's escapes are valid in TOML, which also requires an escaped DEL."""
    return json.dumps(text, ensure_ascii=False).replace("\x7f", "\\u007f")


def _value(value: object) -> str:
    if isinstance(value, np.generic | np.ndarray):
        return _value(value.tolist())
    if isinstance(value, bool):
        return "true" if value else "false"
    if isinstance(value, str):
        return _text(value)
    if isinstance(value, dict):
        entries = (f"{_key(key)} = {_value(entry)}" for key, entry in value.items() if entry is not None)
        return f"{{ {', '.join(entries)} }}"
    if isinstance(value, list | tuple):
        return f"[{', '.join(map(_value, value))}]"
    return repr(value) if isinstance(value, int) else repr(float(value))  # type: ignore[arg-type]
