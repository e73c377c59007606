"""Entries of calibration.json, each checked for presence and kind."""

from collections.abc import Sequence
from pathlib import Path
from typing import Any, final

import numpy as np

from robolaser.errors import CalibrationUnreadable


@final
class Entries:
    """An object of the file: what is asked for must be there and of its kind.

    Raises (every method): CalibrationUnreadable, naming what is wrong and where.

    Args:
        path: The file.
        where: Name of the object in it.
        values: What was read there.
    """

    def __init__(self, path: Path, where: str, values: Any) -> None:
        self.path, self._where = path, where
        if not isinstance(values, dict):
            raise CalibrationUnreadable(path, f"{where or 'the file'} is no object")
        self._values: dict[str, Any] = values

    @property
    def keys(self) -> Sequence[str]:
        """The names of what is in it."""
        return tuple(self._values)

    def has(self, key: str) -> bool:
        """Whether it says something."""
        return self._values.get(key) is not None

    def part(self, key: str) -> "Entries":
        """An object in it."""
        return Entries(self.path, self._name(key), self._get(key))

    def parts(self, key: str) -> list["Entries"]:
        """A list of objects."""
        listed = self._get(key)
        if not isinstance(listed, list):
            raise CalibrationUnreadable(self.path, f"{self._name(key)} is no list")
        return [Entries(self.path, f"{self._name(key)}[{i}]", one) for i, one in enumerate(listed)]

    def text(self, key: str) -> str:
        """A text."""
        found = self._get(key)
        if not isinstance(found, str):
            raise CalibrationUnreadable(self.path, f"{self._name(key)} is no text")
        return found

    def texts(self, key: str) -> tuple[str, ...]:
        """A list of texts."""
        found = self._get(key)
        if not (isinstance(found, list) and all(isinstance(one, str) for one in found)):
            raise CalibrationUnreadable(self.path, f"{self._name(key)} is no list of texts")
        return tuple(found)

    def one_of(self, key: str, words: Sequence[str]) -> str:
        """One of some words."""
        found = self.text(key)
        if found not in words:
            raise CalibrationUnreadable(self.path, f"{self._name(key)} is '{found}', not one of {', '.join(words)}")
        return found

    def number(self, key: str) -> float:
        """A finite number."""
        return self._number(self._name(key), self._get(key))

    def numbers(self, key: str, count: int) -> tuple[float, ...]:
        """So many finite numbers."""
        found = self._get(key)
        if not (isinstance(found, list) and len(found) == count):
            raise CalibrationUnreadable(self.path, f"{self._name(key)} has not {count} numbers")
        return tuple(self._number(self._name(key), one) for one in found)

    def _number(self, name: str, found: Any) -> float:
        if isinstance(found, bool) or not isinstance(found, int | float) or not np.isfinite(found):
            raise CalibrationUnreadable(self.path, f"{name} is no finite number")
        return float(found)

    def _get(self, key: str) -> Any:
        if key not in self._values:
            raise CalibrationUnreadable(self.path, f"it has no {self._name(key)}")
        return self._values[key]

    def _name(self, key: str) -> str:
        return f"{self._where}.{key}".lstrip(".")
