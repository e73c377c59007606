"""JsonObject of calibration.json, each checked for presence and kind."""

import sys
from collections.abc import Sequence
from pathlib import Path
from typing import Any, final

from robolaser.errors import DataError

LARGEST = sys.float_info.max


@final
class JsonObject:
    """An object of the file: what is asked for must be there and of its kind.

    Raises (every method): DataError, naming what is wrong and where.

    Args:
        path: The file.
        where: Name of the object in it.
        values: What was read there.
    """

    def __init__(self, path: Path, where: str, values: Any) -> None:
        self.path, self._where = path, where
        if not isinstance(values, dict):
            raise unusable(path, f"{where or 'the file'} is not an object")
        self._values: dict[str, Any] = values

    @property
    def keys(self) -> Sequence[str]:
        """The names of what is in it."""
        return tuple(self._values)

    def has(self, key: str) -> bool:
        """Whether it says something."""
        return self._values.get(key) is not None

    def part(self, key: str) -> "JsonObject":
        """An object in it."""
        return JsonObject(self.path, self._name(key), self._get(key))

    def parts(self, key: str) -> list["JsonObject"]:
        """A list of objects."""
        listed = self._get(key)
        if not isinstance(listed, list):
            raise unusable(self.path, f"{self._name(key)} is not a list")
        return [JsonObject(self.path, f"{self._name(key)}[{i}]", one) for i, one in enumerate(listed)]

    def text(self, key: str) -> str:
        """A text."""
        found = self._get(key)
        if not _is_text(found):
            raise unusable(self.path, f"{self._name(key)} is not a string")
        return str(found)

    def texts(self, key: str) -> tuple[str, ...]:
        """A list of texts."""
        found = self._get(key)
        if not (isinstance(found, list) and all(map(_is_text, found))):
            raise unusable(self.path, f"{self._name(key)} is not a list of strings")
        return tuple(found)

    def one_of(self, key: str, words: Sequence[str]) -> str:
        """One of some words."""
        found = self.text(key)
        if found not in words:
            raise unusable(self.path, f"{self._name(key)} is '{found}', not one of {', '.join(words)}")
        return found

    def number(self, key: str, *, least: float = -LARGEST) -> float:
        """A finite number, no less than the least."""
        found = self._number(self._name(key), self._get(key))
        if found < least:
            raise unusable(self.path, f"{self._name(key)} is {found:g}, less than {least:g}")
        return found

    def positive(self, key: str) -> float:
        """A finite number above zero."""
        found = self.number(key)
        if not found > 0:
            raise unusable(self.path, f"{self._name(key)} is {found:g}, not above 0")
        return found

    def count(self, key: str) -> int:
        """A whole number from 1."""
        return self._count(self._name(key), self._get(key))

    def counts(self, key: str, count: int) -> tuple[int, ...]:
        """So many whole numbers from 1."""
        self.numbers(key, count)
        return tuple(self._count(self._name(key), one) for one in self._get(key))

    def numbers(self, key: str, count: int) -> tuple[float, ...]:
        """So many finite numbers."""
        found = self._get(key)
        if not (isinstance(found, list) and len(found) == count):
            raise unusable(self.path, f"{self._name(key)} has not {count} numbers")
        return tuple(self._number(self._name(key), one) for one in found)

    def _number(self, name: str, found: Any) -> float:
        if isinstance(found, bool) or not isinstance(found, int | float) or not abs(found) <= LARGEST:
            raise unusable(self.path, f"{name} is not a finite number")
        return float(found)

    def _count(self, name: str, found: Any) -> int:
        number = self._number(name, found)
        if number < 1 or number != int(number):
            raise unusable(self.path, f"{name} is {number:g}, expected a whole number of at least 1")
        return int(number)

    def _get(self, key: str) -> Any:
        if key not in self._values:
            raise unusable(self.path, f"it has no {self._name(key)}")
        return self._values[key]

    def _name(self, key: str) -> str:
        return f"{self._where}.{key}".lstrip(".")


def unusable(path: Path, reason: str) -> DataError:
    """The file is no calibration of a scanner."""
    return DataError(
        f"Cannot use {path}: {reason}. Expected calibration.json of a stripe scanner as `robolaser calibrate` or"
        " `robolaser diagnose` writes it, robot.urdf beside it.",
        file=path,
    )


def _is_text(found: Any) -> bool:
    """Whether it can be written again: JSON spells halves of letters too."""
    return isinstance(found, str) and not any("\ud800" <= letter <= "\udfff" for letter in found)
