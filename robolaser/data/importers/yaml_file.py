"""YAML and JSON files of other tools: numbers and rigid motions under known keys."""

from collections.abc import Mapping, Sequence
from itertools import islice
from pathlib import Path
from typing import Any

import numpy as np

from robolaser.arrays import Array
from robolaser.bounded_reading import CLOUD_BYTES, YAML_BYTES, opened, read_text
from robolaser.data.csv_tables import finite
from robolaser.data.dataset_file import check_rotation
from robolaser.errors import DataError, near
from robolaser.geometry.rigid_motion import from_quaternion, nearest_rotation, pose

PEEKED = 65_536  # letters by which a file is recognised
MOTION = ("x", "y", "z", "qx", "qy", "qz", "qw")
STRETCH = 0.01  # files round their digits


def peek(path: Path) -> str:
    """The beginning of a file as text; "" where there is none."""
    try:
        with opened(path, CLOUD_BYTES) as file:
            return str(file.read(PEEKED), "utf-8", "replace")
    except (DataError, ValueError):
        return ""


def read_yaml(path: Path) -> Any:
    """The contents of a YAML or JSON file: mappings, lists, texts and numbers, and no other objects.

    Raises:
        DataError: It is missing, not text, not YAML, empty, or larger than any such file.
    """
    import yaml  # noqa: PLC0415 - loaded when needed

    text = read_text(path, YAML_BYTES)
    try:
        contents = yaml.safe_load(text)
    except RecursionError:
        raise DataError(f"{path.name} is not valid YAML: it is nested too deeply.", file=path) from None
    except (yaml.YAMLError, ValueError) as error:
        raise DataError(f"{path.name} is not valid YAML: {' '.join(str(error).split())}.", file=path) from None
    if not isinstance(contents, Mapping | list):
        raise DataError(f"{path.name} is empty, or no YAML of named values.", file=path)
    return contents


def under(values: Any, key: str, file: str, where: str = "") -> Any:
    """The value of a key.

    Raises:
        DataError: The key is missing.
    """
    if not isinstance(values, Mapping) or key not in values:
        there = map(str, islice(values, 20)) if isinstance(values, Mapping) else ()
        at = f", {where}" if where else ""
        raise DataError(f"{file}{at} lacks {key}.{near(key, there)}", file=file, column=key)
    return values[key]


def numbers(values: Any, count: int, file: str, where: str) -> Array:
    """A list of finite numbers, (count,); a list of lists is flattened.

    Raises:
        DataError: It is something else.
    """
    flat: list[Any] = []
    for value in values if isinstance(values, Sequence) and not isinstance(values, str) else [values]:
        flat += value if isinstance(value, list) else [value]
    right = len(flat) == count and all(isinstance(value, int | float) and not isinstance(value, bool) for value in flat)
    found = np.array([finite(repr(value)) for value in flat] if right else [np.nan])
    if not np.isfinite(found).all():
        what = "a finite number" if count == 1 else f"{count} finite numbers"
        raise DataError(f"{file}, {where}: {str(values)[:80]}, expected {what}.", file=file, column=where)
    return found


def number(values: Any, key: str, file: str, where: str) -> float:
    """The finite number under a key.

    Raises:
        DataError: There is none.
    """
    return float(numbers(under(values, key, file, where), 1, file, f"{where}.{key}")[0])


def motion(values: Any, file: str, where: str) -> Array:
    """A rigid motion of the keys x y z qx qy qz qw, or ROS's translation and rotation, (4, 4).

    Raises:
        DataError: A key is missing, or the quaternion's length is not one.
    """
    parts: list[tuple[Any, Sequence[str]]] = [(values, MOTION)]
    if isinstance(values, Mapping) and "translation" in values:
        parts = [(under(values, "translation", file, where), "xyz"), (under(values, "rotation", file, where), "xyzw")]
    seven = [number(part, key, file, where) for part, keys in parts for key in keys]
    return motion_of_seven(np.array(seven), file, where)


def motion_of_seven(seven: Array, file: str, where: str) -> Array:
    """A rigid motion of (x, y, z, qx, qy, qz, qw), (4, 4).

    Raises:
        DataError: A number is not finite, or the quaternion's length is not one.
    """
    if not np.isfinite(seven).all():
        raise DataError(f"{file}, {where}: its numbers are not all finite: {seven.tolist()}.", file=file)
    check_rotation(seven[3:], f"{file}, {where}", file)
    return pose(from_quaternion(seven[3:]), seven[:3])


def motion_of_matrix(matrix: Array, file: str, where: str) -> Array:
    """A rigid motion of a 4 x 4 or 3 x 4 matrix whose digits were rounded, (4, 4).

    Raises:
        DataError: It is none.
    """
    R, stretch = nearest_rotation(matrix[:3, :3])
    last = matrix[3] if len(matrix) == 4 else np.array([0.0, 0.0, 0.0, 1.0])
    if np.abs(stretch - 1).max() > STRETCH or np.abs(last - [0, 0, 0, 1]).max() > STRETCH:
        raise DataError(f"{file}, {where}: the matrix is not a rigid motion. Is it the transpose of one?", file=file)
    return pose(R, matrix[:3, 3])
