"""Settings as they are typed: what a value may be, and what an algorithm understands."""

import math
from collections.abc import Callable, Iterable, Mapping
from dataclasses import dataclass
from typing import final

from robolaser.errors import SettingSenseless, SettingUnknown

Value = int | float | bool | str | None
"""Of a setting: a whole number, a number, yes or no, a word, or nothing."""

_WORDS: Mapping[str, Value] = {"true": True, "false": False, "none": None}


@final
@dataclass(frozen=True)
class Setting:
    """One that an algorithm understands.

    Attributes:
        name: Its key.
        expected: What it may be, for a person.
        fits: Whether a value has a meaning.
    """

    name: str
    expected: str
    fits: Callable[[Value], bool]

    def of(self, part: str) -> "Setting":
        """The same as a part's: `prob` of the crossover is `crossover.prob`."""
        return Setting(f"{part}.{self.name}", self.expected, self.fits)


def whole(name: str, least: int = 1) -> Setting:
    """A whole number."""

    def fits(value: Value) -> bool:
        return isinstance(value, int) and not isinstance(value, bool) and value >= least

    return Setting(name, f"a whole number from {least} up", fits)


def number(name: str, least: float = 0.0, most: float = math.inf) -> Setting:
    """A finite number from one to another."""

    def fits(value: Value) -> bool:
        if isinstance(value, bool) or not isinstance(value, int | float):
            return False
        return math.isfinite(value) and least <= value <= most

    upwards = "up" if most == math.inf else f"to {most:g}"
    return Setting(name, f"a number from {least:g} {upwards}", fits)


def share(name: str) -> Setting:
    """A probability, or another share."""
    return number(name, 0.0, 1.0)


def switch(name: str) -> Setting:
    """Yes or no."""
    return Setting(name, "true or false", lambda value: isinstance(value, bool))


def word(name: str, words: Iterable[str]) -> Setting:
    """One of some words."""
    known = tuple(words)
    return Setting(name, f"one of {', '.join(known)}", lambda value: value in known)


def read(text: str) -> Value:
    """A value as typed."""
    if text.casefold() in _WORDS:
        return _WORDS[text.casefold()]
    for kind in (int, float):
        try:
            return kind(text)
        except ValueError:
            continue
    return text


def check(algorithm: str, given: Mapping[str, Value], known: Iterable[Setting]) -> None:
    """See that an algorithm understands all its settings.

    Raises:
        SettingUnknown: It has none of that name.
        SettingSenseless: A value has no meaning.
    """
    by_name = {setting.name: setting for setting in known}
    for name, value in given.items():
        if name not in by_name:
            raise SettingUnknown(algorithm, name, by_name)
        if not by_name[name].fits(value):
            raise SettingSenseless(algorithm, name, value, by_name[name].expected)
