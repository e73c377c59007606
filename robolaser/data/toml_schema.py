"""dataset.toml and cell.toml: their values, each checked for presence and kind."""

import sys
import tomllib
from collections.abc import Iterator, Mapping, Sequence
from pathlib import Path
from typing import Any, final

import numpy as np

from robolaser.data.csv_tables import read_text
from robolaser.errors import AngleTooLarge, BoundsWrong, NotPositive, NotToml, SettingMissing, SettingWrong, meant
from robolaser.parameters import Parameter

UNITS = {
    "f": "m", "s_u": "m/px", "s_v": "m/px", "u_0": "px", "v_0": "px", "k": "1/m²", "b": "m", "theta": "rad",
    "w": "rad", "phi": "rad", "psi": "rad", "t_x": "m", "t_y": "m", "t_z": "m",
    "x": "m", "y": "m", "z": "m",
}  # fmt: skip
"""Unit of a parameter by its name, or by the last part of a dotted name."""
POSITIVE = ("f", "s_u", "s_v")
"""Lengths that a camera has; b and theta may be negative."""
LARGEST = sys.float_info.max
BOUNDS = ("nominal", "lower", "upper")


KNOWN = {
    "": ("format", "name", "source", "licence", "robot", "sensor", "scanner", "image", "board", "target", "noise",
         "parameters", "arm", "camera", "laser", "limits"),
    "robot": ("urdf", "flange", "joints", "gravity", "time", "path"),
    "sensor": ("kind", "stripe_axis"),
    "scanner": ("bracket_quat", "angles"),
    "image": ("width_px", "height_px"),
    "board": ("columns", "rows", "square_m"),
    "target": ("placed", "distances_m"),
    "noise": ("pixel_px", "target_m", "joint_rad", "point_m", "distance_m"),
    "arm": ("kind", "port", "baud", "flow", "ids", "reference_rad", "direction", "home"),
    "camera": ("source", "exposure", "gain", "settle_s"),
    "laser": ("output",),
    "limits": ("floor_m", "reach_m", "speed_rad_s"),
}  # fmt: skip
"""Keys of each section; what else is there is passed over."""


def unit_of(name: str) -> str:
    """The SI unit of a sensor's parameter."""
    return UNITS.get(name.rsplit(".", 1)[-1], "")


@final
class Settings:
    """One section of a file of settings.

    Raises (every method): SettingMissing, SettingWrong, each naming file, section and key.
    """

    def __init__(self, section: str, values: Mapping[str, Any], file: str = "dataset.toml") -> None:
        self._section = section
        self._values = values
        self._file = file

    def __contains__(self, key: str) -> bool:
        return key in self._values

    def key(self, key: str) -> str:
        """How messages name a key."""
        return f"[{self._section}] {key}" if self._section else key

    def section(self, name: str) -> "Settings":
        """A section below this one; empty when absent."""
        values = self._values.get(name, {})
        if not isinstance(values, dict):
            raise self._wrong(name, values, f"a section [{name}]")
        return Settings(name, values, self._file)

    def passed_over(self) -> list[str]:
        """A sentence for each key, here and in the sections below, that nothing reads: it may be misspelt."""
        known = KNOWN.get(self._section, self._values)
        here = [
            f"{self._file}, {self.key(key)} is not known and was passed over.{meant(key, known)}"
            for key in self._values
            if key not in known
        ]
        below = [self.section(key) for key, value in self._values.items() if key in KNOWN and isinstance(value, dict)]
        return [*here, *(sentence for section in below for sentence in section.passed_over())]

    def text(self, key: str, *, default: str | None = None, one_of: Sequence[str] = ()) -> str:
        """A text, from a list where one is given."""
        value = self._get(key, default, "a text")
        if not isinstance(value, str) or (one_of and value not in one_of):
            raise self._wrong(self.key(key), value, " or ".join(f'"{x}"' for x in one_of) or "a text")
        return value

    def text_or_count(self, key: str) -> str | int:
        """A text or a whole number from 0, which must be there."""
        value = self._get(key, None, "a text or a whole number from 0")
        if isinstance(value, bool) or not isinstance(value, str | int) or value == "":
            raise self._wrong(self.key(key), value, "a text or a whole number from 0")
        return value if isinstance(value, str) else self.count(key, least=0)

    def flag(self, key: str, *, default: bool) -> bool:
        """True or false."""
        value = self._get(key, default, "true or false")
        if not isinstance(value, bool):
            raise self._wrong(self.key(key), value, "true or false")
        return value

    def number(self, key: str, *, positive: bool = False, default: float | None = None) -> float:
        """A finite number, which must be there if it has no default."""
        expected = "a positive number" if positive else "a finite number"
        value = self._get(key, default, expected)
        if not _is_number(value) or (positive and value <= 0):
            raise self._wrong(self.key(key), value, expected)
        return float(value)

    def count(self, key: str, *, least: int, default: int | None = None) -> int:
        """A whole number, which must be there if it has no default."""
        value = self._get(key, default, f"a whole number from {least}")
        if isinstance(value, bool) or not isinstance(value, int) or value < least:
            raise self._wrong(self.key(key), value, f"a whole number from {least}")
        return value

    def numbers(self, key: str, length: int, *, default: Sequence[float]) -> tuple[float, ...]:
        """A list of finite numbers."""
        value = self._get(key, list(default), f"a list of {length} numbers")
        if not isinstance(value, list) or len(value) != length or not all(_is_number(x) for x in value):
            raise self._wrong(self.key(key), value, f"a list of {length} finite numbers")
        return tuple(float(x) for x in value)

    def texts(self, key: str) -> tuple[str, ...] | None:
        """A list of different texts; None when absent."""
        value = self._values.get(key)
        if value is None:
            return None
        good = isinstance(value, list) and value and all(isinstance(x, str) and x for x in value)
        if not good or len(set(value)) < len(value):
            raise self._wrong(self.key(key), value, "a list of different names")
        return tuple(value)

    def distances(self, key: str, known: Sequence[str]) -> tuple[tuple[str, str, float], ...]:
        """Triples (socket, socket, distance in m) between known sockets."""
        out = []
        for triple in self._get(key, [], "a list of triples"):
            good = isinstance(triple, list) and len(triple) == 3 and _is_number(triple[2]) and triple[2] > 0
            if not good or triple[0] not in known or triple[1] not in known or triple[0] == triple[1]:
                expected = f"[socket, another socket, distance in m], sockets among: {', '.join(known)}"
                raise self._wrong(self.key(key), triple, expected)
            out.append((str(triple[0]), str(triple[1]), float(triple[2])))
        return tuple(out)

    def parameters(self) -> dict[str, Parameter]:
        """Every key as a parameter with nominal value and bounds; `target.x = ...` and `"target.x" = ...` are one.

        Raises:
            BoundsWrong: Bounds are swapped, or exclude the nominal value.
            AngleTooLarge: An angle is beyond a full turn.
            NotPositive: A length of the camera may become zero.
        """
        out = {}
        for name, given in _leaves(self._values):
            if not isinstance(given, dict):
                raise self._wrong(self.key(name), given, "{ nominal = ..., lower = ..., upper = ... }")
            numbers = []
            for part in BOUNDS:
                if part not in given:
                    raise self._missing(f"{self.key(name)}.{part}", "a finite number")
                if not _is_number(given[part]):
                    raise self._wrong(f"{self.key(name)}.{part}", given[part], "a finite number")
                numbers.append(float(given[part]))
            nominal, lower, upper = numbers
            if not lower < upper or not lower <= nominal <= upper:
                raise BoundsWrong(name, nominal, lower, upper)
            if name in POSITIVE and lower <= 0:
                raise NotPositive(name, lower)
            unit = unit_of(name)
            largest = max(numbers, key=abs)
            if unit == "rad" and abs(largest) > 2 * np.pi:
                raise AngleTooLarge(name, largest)
            out[name] = Parameter(name, unit, nominal, lower, upper)
        return out

    def _missing(self, key: str, expected: str) -> SettingMissing:
        return SettingMissing(key, expected, self._file)

    def _wrong(self, key: str, value: object, expected: str) -> SettingWrong:
        return SettingWrong(key, value, expected, self._file)

    def _get(self, key: str, default: Any, expected: str) -> Any:
        value = self._values.get(key, default)
        if value is None:
            raise self._missing(self.key(key), expected)
        return value


def _leaves(values: Mapping[str, Any]) -> Iterator[tuple[str, Any]]:
    """Names and what they stand for; TOML reads a name with dots as tables within tables."""
    for name, given in values.items():
        if isinstance(given, dict) and given and not given.keys() & set(BOUNDS) and _all_tables(given):
            yield from ((f"{name}.{rest}", value) for rest, value in _leaves(given))
        else:
            yield name, given


def _all_tables(values: Mapping[str, Any]) -> bool:
    return all(isinstance(value, dict) for value in values.values())


def _is_number(value: object) -> bool:
    return isinstance(value, int | float) and not isinstance(value, bool) and abs(value) <= LARGEST


def read_settings(path: Path) -> Settings:
    """Parse a file of settings.

    Raises:
        FileUnreadable: It is not there or not text.
        NotToml: It is not TOML.
    """
    try:
        return Settings("", tomllib.loads(read_text(path)), path.name)
    except tomllib.TOMLDecodeError as error:
        raise NotToml(path, str(error)) from None
