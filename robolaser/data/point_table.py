"""points.csv: what was seen, by the columns that the sensor's format declares."""

from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from robolaser.arrays import Array, Ints
from robolaser.data.csv_tables import CsvTable, bad_cell, bad_row
from robolaser.data.dataset import Dataset, Points
from robolaser.data.pose_table import check_quaternions, not_too_far
from robolaser.data.sensor_format import PIXEL
from robolaser.data.toml_schema import wrong
from robolaser.errors import meant

LARGEST_REPEAT = 1e9


def points_of(table: CsvTable, described: Dataset) -> Points:
    """The points of a table with the columns of points.csv.

    Args:
        table: Its numbers may be texts.
        described: What dataset.toml says, with the poses.

    Raises:
        DataError: With row and column of what is wrong.
    """
    declared = described.format
    in_pose = table.texts("pose")
    points = Points(_numbers_of(table, in_pose, described.poses.names), table.texts("point"))
    if "repeat" in table:
        points = replace(points, repeat=_repeats(table))
    if not declared.many_rows:
        shots = points.place
        if points.repeat is not None:
            repeat = np.unique(points.repeat, return_inverse=True)[1]
            shots = shots * (repeat.max(initial=0) + 1) + repeat
        table.check_all_differ(shots.tolist(), lambda row: _shown(points, row, in_pose[row]))
    for column, why in declared.absent.items():
        if column in table:
            raise wrong("dataset.toml", ("sensor", "kind"), declared.kind, f"{table.file} without {column}: {why}")
    arrays = {name: table.numbers(columns) for name, columns in declared.columns.items()}
    if "xyz" in arrays:
        not_too_far(table, arrays["xyz"])
    if "quaternion" in arrays:
        check_quaternions(table, arrays["quaternion"])
    if "pixel" in arrays and described.image_px is not None:
        _in_the_image(table, arrays["pixel"], described.image_px)
    if "pixel" in arrays:
        _not_at_one_pixel(table, points, arrays["pixel"])
    return points.with_arrays(arrays)


def _numbers_of(table: CsvTable, in_pose: Sequence[str], poses: Sequence[str]) -> Ints:
    """Number of each row's pose, (m,)."""
    number = {name: i for i, name in enumerate(poses)}
    strangers = set(in_pose) - set(number)
    if strangers:
        row = min(map(in_pose.index, strangers))
        there = f"no pose {in_pose[row]!r} in poses.csv, which has {len(poses)}.{meant(in_pose[row], poses)}"
        raise bad_row(table.file, table.lines[row], f"{there} Add the pose or delete the row.", "pose")
    return np.fromiter(map(number.__getitem__, in_pose), np.int64, len(in_pose))


def _repeats(table: CsvTable) -> Ints:
    numbers = table.numbers(["repeat"])[:, 0]
    for i in np.flatnonzero((numbers != np.round(numbers)) | (np.abs(numbers) > LARGEST_REPEAT))[:1]:
        expected = f"a whole number up to {LARGEST_REPEAT:.0g}"
        raise bad_cell(table.file, table.lines[i], "repeat", f"{numbers[i]:.12g}", expected)
    return numbers.astype(np.int64)


def _shown(points: Points, row: int, pose: str) -> str:
    repeat = "" if points.repeat is None else f", repeat {points.repeat[row]}"
    return f"pose {pose}, point {points.names[row]}{repeat}"


def _in_the_image(table: CsvTable, pixel: Array, image_px: tuple[int, int]) -> None:
    for row, axis in np.argwhere((pixel < -0.5) | (pixel > np.array(image_px) - 0.5))[:1].tolist():
        raise bad_row(
            table.file,
            table.lines[row],
            f"pixel ({pixel[row, 0]:.6g}, {pixel[row, 1]:.6g}) is outside the image of {image_px[0]} x {image_px[1]}"
            " pixels. Correct the row, or [image] in dataset.toml.",
            PIXEL[axis],
        )


def _not_at_one_pixel(table: CsvTable, points: Points, pixel: Array) -> None:
    """See that no pose has different points that are all at one pixel."""
    _, first, pose = np.unique(points.pose, return_index=True, return_inverse=True)
    apart = np.bincount(pose, (pixel != pixel[first][pose]).any(axis=1))
    places = np.bincount(pose[np.unique(points.place, return_index=True)[1]])
    for row in first[(apart == 0) & (places > 1)][:1].tolist():
        there = f"({pixel[row, 0]:.6g}, {pixel[row, 1]:.6g})"
        here = f"all points of pose {table.texts('pose')[row]} are at one pixel, {there}"
        raise bad_row(table.file, table.lines[row], f"{here}. Are these the right columns? Otherwise delete the rows.")
