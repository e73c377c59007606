"""`[parameters]` of dataset.toml: nominal values and bounds, by name."""

from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from typing import Any, final

import numpy as np

from robolaser.data.sensor_format import SensorFormat
from robolaser.data.toml_schema import refused, typed, wrong
from robolaser.parameters import Parameter

FULL_TURN = 2 * np.pi


@final
@dataclass(frozen=True)
class ParameterEntry:
    """One of `[parameters]`."""

    nominal: float
    lower: float | None = None
    upper: float | None = None
    fixed: bool = False


def parameters_of(table: Mapping[str, Any], declared: SensorFormat, file: str) -> dict[str, Parameter]:
    """Every key as a parameter; `target.x = ...` and `"target.x" = ...` are one."""
    found = {}
    for name, values in _entries(table):
        at = ("parameters", name)
        if not isinstance(values, dict):
            raise wrong(file, at, values, "{ nominal = ..., lower = ..., upper = ... }")
        entry = typed(values, ParameterEntry, file=file, at=at)
        reason = _fault(name, entry, declared)
        if reason:
            raise refused(file, f"[parameters] {name}", reason)
        lower, upper = (entry.nominal if end is None else end for end in (entry.lower, entry.upper))
        found[name] = Parameter(name, declared.unit_of(name), entry.nominal, lower, upper)
    return found


def _fault(name: str, entry: ParameterEntry, declared: SensorFormat) -> str:
    """What is wrong with a parameter's numbers; "" where nothing is."""
    nominal, lower, upper = entry.nominal, entry.lower, entry.upper
    if entry.fixed:
        if (lower, upper) != (None, None):
            return "it is fixed at its nominal value, and has no bounds. Delete fixed, or lower and upper."
        lower = upper = nominal
    elif lower is None or upper is None:
        missing = "lower" if lower is None else "upper"
        return f"{missing} is missing: expected a number, or fixed = true to hold it at its nominal value."
    elif not lower <= nominal <= upper or lower == upper:
        why = "the nominal value must lie between the bounds" if lower < upper else "lower must be below upper"
        return f"nominal {nominal:g}, lower {lower:g}, upper {upper:g}; {why}."
    if name in declared.positive and lower <= 0:
        return f"lower is {lower:g}, but this parameter is positive. Give a lower bound above zero."
    largest = max((nominal, lower, upper), key=abs)
    if declared.unit_of(name) == "rad" and abs(largest) > FULL_TURN:
        return f"{largest:g} rad is more than a full turn. Are these degrees?"
    return ""


def _entries(table: Mapping[str, Any]) -> Iterator[tuple[str, Any]]:
    """Names and what they stand for; TOML reads a name with dots as tables within tables."""
    known = set(ParameterEntry.__annotations__)
    for name, values in table.items():
        tables = isinstance(values, dict) and values and all(isinstance(value, dict) for value in values.values())
        if tables and not values.keys() & known:
            yield from ((f"{name}.{rest}", value) for rest, value in _entries(values))
        else:
            yield name, values
