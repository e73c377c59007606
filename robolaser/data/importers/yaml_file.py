"""YAML and JSON files of other tools, whose values know their place in the file."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from itertools import islice
from pathlib import Path
from typing import Any, final

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


@final
@dataclass(frozen=True)
class Entry:
    """A file's contents, or a value in them; each access raises a DataError where the file has something else."""

    value: Any  # a mapping, list, text or number
    file: str  # its file, for messages
    where: str = ""  # its place there, for messages; "": the whole file

    def __str__(self) -> str:
        """Its place in a message."""
        return f"{self.file}, {self.where}" if self.where else self.file

    def __contains__(self, key: str) -> bool:
        return isinstance(self.value, Mapping) and key in self.value

    def __getitem__(self, key: str) -> "Entry":
        """The value of a key."""
        if key not in self:
            there = map(str, islice(self.value, 20)) if isinstance(self.value, Mapping) else ()
            raise DataError(f"{self} lacks {key}.{near(key, there)}", file=self.file, column=key)
        joint = ", " if self.where[-1:].isdigit() else "." if self.where else ""
        return Entry(self.value[key], self.file, f"{self.where}{joint}{key}")

    def entries(self, name: str) -> list["Entry"]:
        """The entries of a list, each called by this name and its number."""
        if not isinstance(self.value, list):
            raise DataError(f"{self}: expected a list.", file=self.file)
        before = f"{self.where}, " if self.where else ""
        return [Entry(one, self.file, f"{before}{name} {i}") for i, one in enumerate(self.value, 1)]

    def numbers(self, count: int) -> Array:
        """Finite numbers, (count,); a list of lists is flattened."""
        flat: list[Any] = []
        for one in self.value if isinstance(self.value, list) else [self.value]:
            flat += one if isinstance(one, list) else [one]
        right = len(flat) == count and all(isinstance(one, int | float) and not isinstance(one, bool) for one in flat)
        found = np.array([finite(repr(one)) for one in flat] if right else [np.nan])
        if not np.isfinite(found).all():
            what = "a finite number" if count == 1 else f"{count} finite numbers"
            raise DataError(f"{self}: {str(self.value)[:80]}, expected {what}.", file=self.file, column=self.where)
        return found

    def number(self) -> float:
        """A finite number."""
        return float(self.numbers(1)[0])

    def motion(self) -> Array:
        """The rigid motion of the keys x y z qx qy qz qw, or of ROS's translation and rotation, (4, 4)."""
        parts: list[tuple[Entry, Sequence[str]]] = [(self, MOTION)]
        if "translation" in self:
            parts = [(self["translation"], "xyz"), (self["rotation"], "xyzw")]
        seven = np.array([part[key].number() for part, keys in parts for key in keys])
        return motion_of_seven(seven, self.file, self.where)

    def matrix(self) -> Array:
        """The rigid motion of sixteen numbers, row by row, (4, 4)."""
        return motion_of_matrix(self.numbers(16).reshape(4, 4), self.file, self.where)


def peek(path: Path) -> str:
    """The beginning of a file as text; "" where there is none."""
    try:
        with opened(path, CLOUD_BYTES) as file:
            return str(file.read(PEEKED), "utf-8", "replace")
    except (DataError, ValueError):
        return ""


def read_yaml(path: Path) -> Entry:
    """The contents of a YAML or JSON file, a mapping or a list, and no other objects."""
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
    return Entry(contents, path.name)


def motion_of_seven(seven: Array, file: str, where: str) -> Array:
    """A rigid motion of (x, y, z, qx, qy, qz, qw), (4, 4)."""
    if not np.isfinite(seven).all():
        raise DataError(f"{file}, {where}: its numbers are not all finite: {seven.tolist()}.", file=file)
    check_rotation(seven[3:], f"{file}, {where}", file)
    return pose(from_quaternion(seven[3:]), seven[:3])


def motion_of_matrix(matrix: Array, file: str, where: str) -> Array:
    """A rigid motion of a 4 x 4 or 3 x 4 matrix whose digits were rounded, (4, 4)."""
    R, stretch = nearest_rotation(matrix[:3, :3])
    last = matrix[3] if len(matrix) == 4 else np.array([0.0, 0.0, 0.0, 1.0])
    if np.abs(stretch - 1).max() > STRETCH or np.abs(last - [0, 0, 0, 1]).max() > STRETCH:
        raise DataError(f"{file}, {where}: the matrix is not a rigid motion. Is it the transpose of one?", file=file)
    return pose(R, matrix[:3, 3])
