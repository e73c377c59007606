"""Settings of algorithms and operators: how a typed value is read, and which values make sense."""

import math
from collections.abc import Callable, Iterable, Mapping
from dataclasses import dataclass
from typing import final

from robolaser.errors import RobolaserError, UsageError, near

Value = int | float | bool | str | None  # a setting's value

_WORDS: Mapping[str, Value] = {"true": True, "false": False, "none": None}


@final
@dataclass(frozen=True)
class Setting:
    """A setting that an algorithm has."""

    name: str  # its key
    expected: str  # the values that make sense, in words
    fits: Callable[[Value], bool]  # whether a value makes sense

    def of(self, slot: str) -> "Setting":
        """The same setting of an operator in a slot: `prob` of the crossover is `crossover.prob`."""
        return Setting(f"{slot}.{self.name}", self.expected, self.fits)


def whole(name: str, least: int = 1) -> Setting:
    """A whole number."""

    def fits(value: Value) -> bool:
        return isinstance(value, int) and not isinstance(value, bool) and value >= least

    return Setting(name, f"a whole number of at least {least}", fits)


def number(name: str, least: float = 0.0, most: float = math.inf) -> Setting:
    """A finite number between two others."""

    def fits(value: Value) -> bool:
        if isinstance(value, bool) or not isinstance(value, int | float):
            return False
        return math.isfinite(value) and least <= value <= most

    limits = f"of at least {least:g}" if most == math.inf else f"from {least:g} to {most:g}"
    return Setting(name, f"a number {limits}", fits)


def share(name: str) -> Setting:
    """A probability, or another share."""
    return number(name, 0.0, 1.0)


def switch(name: str) -> Setting:
    """True or false."""
    return Setting(name, "true or false", lambda value: isinstance(value, bool))


def word(name: str, words: Iterable[str]) -> Setting:
    """One of several words."""
    known = tuple(words)
    return Setting(name, f"one of {', '.join(known)}", lambda value: value in known)


def read(text: str) -> Value:
    """Read a value as typed."""
    if text.casefold() in _WORDS:
        return _WORDS[text.casefold()]
    for kind in (int, float):
        try:
            return kind(text)
        except ValueError:
            continue
    return text


def check(algorithm: str, given: Mapping[str, Value], known: Iterable[Setting]) -> None:
    """Check that an algorithm has all settings that are given, with values that make sense.

    Raises:
        UsageError: It has no such setting, or the value makes no sense.
    """
    by_name = {setting.name: setting for setting in known}
    for name, value in given.items():
        if name not in by_name:
            raise unknown_setting(algorithm, name, by_name)
        if not by_name[name].fits(value):
            raise UsageError(f"{algorithm}: {name} is {value!r}, expected {by_name[name].expected}.")


def unknown_setting(algorithm: str, name: str, known: Iterable[str]) -> UsageError:
    """An algorithm has no such setting."""
    return UsageError(f"{algorithm} has no setting '{name}'.{near(name, known)}")


def not_made(text: str, error: Exception) -> UsageError:
    """An algorithm raised an error when it was made with its settings."""
    reason = str(error) if isinstance(error, RobolaserError) else f"{type(error).__name__}: {error}"
    return UsageError(f"{text} cannot be made. {reason.rstrip('.')}. Give it other settings.")
