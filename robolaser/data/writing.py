"""A data set as a folder on disk: what `load` reads, written so that it reads the same again."""

import json
from collections.abc import Iterator, Sequence
from pathlib import Path

from robolaser.arrays import Array
from robolaser.data.csv_tables import write_table, write_text
from robolaser.data.dataset import Dataset
from robolaser.data.loading import AT_THE_POSE, FLANGE_COLUMNS, FORMAT, GRAVITY
from robolaser.errors import FileUnwritable, OutputExists
from robolaser.geometry.rigid_motion import to_quaternion

FILES = ("dataset.toml", "poses.csv", "points.csv")


def save(dataset: Dataset, folder: str | Path, *, overwrite: bool = False) -> None:
    """Write a data set; images stay where they are, only their paths are written.

    dataset.toml comes last: a folder that was cut off half way is no data set.

    Args:
        dataset: Without points it becomes a raw recording, which has no points.csv.
        folder: Created where it is not there.
        overwrite: Replace a data set that is there.

    Raises:
        OutputExists: There is one.
        FileUnwritable: The disk or the rights say no.
    """
    folder = Path(folder)
    for file in FILES:
        if not overwrite and (folder / file).exists():
            raise OutputExists(folder / file)
    try:
        folder.mkdir(parents=True, exist_ok=True)
    except OSError as error:
        raise FileUnwritable(folder, error.strerror or str(error)) from None
    if dataset.robot is not None:
        write_text(folder / "robot.urdf", dataset.robot.urdf)
    _write_columns(folder / "poses.csv", dict(_poses(dataset)))
    if len(dataset.points):
        save_points(dataset, folder)
    else:
        (folder / "points.csv").unlink(missing_ok=True)
    write_text(folder / "dataset.toml", "\n".join(_settings(dataset)) + "\n")


def save_points(dataset: Dataset, folder: Path) -> None:
    """Write points.csv and nothing else."""
    _write_columns(folder / "points.csv", dict(_points(dataset)))


def _write_columns(path: Path, columns: dict[str, Sequence[str]]) -> None:
    write_table(path, list(columns), zip(*columns.values(), strict=True))


def _digits(values: Array) -> list[str]:
    """Every bit of each number: the shortest text that reads back the same."""
    return [repr(float(value)) for value in values]


def _spread(names: Sequence[str], values: Array) -> Iterator[tuple[str, Sequence[str]]]:
    yield from ((name, _digits(values[:, i])) for i, name in enumerate(names))


def _poses(dataset: Dataset) -> Iterator[tuple[str, Sequence[str]]]:
    poses, robot = dataset.poses, dataset.robot
    yield "pose", poses.names
    if poses.time_s is not None:
        yield "time_s", _digits(poses.time_s)
    if robot is not None and poses.q is not None:
        yield from _spread([f"q_{joint}" for joint in robot.joints], poses.q)
        if poses.qd is not None:
            yield from _spread([f"qd_{joint}" for joint in robot.joints], poses.qd)
    if robot is None and poses.T_base_flange is not None:
        T = poses.T_base_flange
        yield from _spread(FLANGE_COLUMNS[:3], T[:, :3, 3])
        yield from _spread(FLANGE_COLUMNS[3:], to_quaternion(T[:, :3, :3]))
    if poses.image is not None:
        yield "image", poses.image
    for column in AT_THE_POSE:
        values = getattr(poses, column)
        if values is not None:
            yield column, _digits(values)
    for column in AT_THE_POSE:
        values = getattr(poses, column)
        if values is not None:
            yield column, _digits(values)
    yield from poses.extra.items()


def _points(dataset: Dataset) -> Iterator[tuple[str, Sequence[str]]]:
    points = dataset.points
    yield "pose", [dataset.poses.names[i] for i in points.pose]
    yield "point", points.names
    if points.repeat is not None:
        yield "repeat", [str(shot) for shot in points.repeat]
    for name, columns in dataset.format.columns.items():
        yield from _spread(columns, points[name])


def _settings(dataset: Dataset) -> Iterator[str]:
    yield f"format = {_text(FORMAT)}"
    yield f"name = {_text(dataset.name)}"
    for key, said in (("source", dataset.source), ("licence", dataset.licence)):
        if said:
            yield f"{key} = {_text(said)}"
    yield from _robot(dataset)
    yield from ("", "[sensor]", f"kind = {_text(dataset.kind)}")
    if dataset.kind == "stripe":
        yield f"stripe_axis = {_text(dataset.stripe_axis)}"
        yield from ("", "[scanner]", f"bracket_quat = {_numbers(dataset.bracket_quat)}")
        yield f"angles = {_text(dataset.angles)}"
    if dataset.image_px is not None:
        width, height = dataset.image_px
        yield from ("", "[image]", f"width_px = {width}", f"height_px = {height}")
    if dataset.board is not None:
        yield from ("", "[board]", f"columns = {dataset.board.columns}", f"rows = {dataset.board.rows}")
        yield f"square_m = {_number(dataset.board.square_m)}"
    yield from ("", "[target]", f"placed = {'true' if dataset.placed else 'false'}")
    if dataset.distances_m:
        triples = (f"[{_text(a)}, {_text(b)}, {_number(distance)}]" for a, b, distance in dataset.distances_m)
        yield f"distances_m = [{', '.join(triples)}]"
    known = {key: value for key, value in vars(dataset.noise).items() if value is not None}
    if known:
        yield from ("", "[noise]", *(f"{key} = {_number(value)}" for key, value in known.items()))
    if dataset.parameters:
        yield from ("", "[parameters]")
        for name, item in dataset.parameters.items():
            bounds = f"lower = {_number(item.lower)}, upper = {_number(item.upper)}"
            yield f"{_key(name)} = {{ nominal = {_number(item.nominal)}, {bounds} }}"


def _robot(dataset: Dataset) -> Iterator[str]:
    robot = dataset.robot
    if robot is None:
        return
    yield from ("", "[robot]", 'urdf = "robot.urdf"', f"flange = {_text(robot.flange)}")
    yield f"joints = [{', '.join(map(_text, robot.joints))}]"
    if robot.gravity != GRAVITY:
        yield f"gravity = {_numbers(robot.gravity)}"
    if dataset.time_is_order:
        yield 'time = "order"'
    if not dataset.path_known:
        yield 'path = "unknown"'


def _key(name: str) -> str:
    return name if name.isascii() and name.replace("_", "a").replace("-", "a").isalnum() else _text(name)


def _text(text: str) -> str:
    """A TOML string: JSON's escapes are TOML's, save that TOML wants DEL escaped too."""
    return json.dumps(text, ensure_ascii=False).replace("\x7f", "\\u007f")


def _number(value: float) -> str:
    return repr(float(value))


def _numbers(values: Sequence[float]) -> str:
    return f"[{', '.join(map(_number, values))}]"
