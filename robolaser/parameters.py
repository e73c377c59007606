"""Named numbers with unit, nominal value and bounds, and the flat vector of an optimiser."""

from collections.abc import Iterable, Mapping
from dataclasses import dataclass, replace
from functools import cached_property
from typing import final

import numpy as np

from robolaser.arrays import Array

FIXED_WIDTH = 0.1
Values = Mapping[str, Array]  # one array (c,) for each parameter's name: the same numbers as a batch (c, d), unpacked


def as_batch(numbers: Mapping[str, float]) -> dict[str, Array]:
    """Numbers by name as arrays of one candidate, (1,) each."""
    return {name: np.array([number]) for name, number in numbers.items()}


def from_batch(values: Values) -> dict[str, float]:
    """The numbers of the only candidate, or of the first one, by name."""
    return {name: float(value[0]) for name, value in values.items()}


@final
@dataclass(frozen=True)
class Parameter:
    """One number of a model; bounds without room hold it at its nominal value."""

    name: str  # in files and messages
    unit: str  # SI; "" for a pure number, "px" for pixels
    nominal: float  # where the search starts
    lower: float  # bound of the search
    upper: float  # the other one
    given: bool = True  # whether nominal and bounds come from the user; otherwise from a closed form
    origin: str = ""  # source of the closed form's value: "the board's corners"

    @property
    def fixed(self) -> bool:
        """Whether it is held at its nominal value."""
        return self.upper <= self.lower

    def renamed(self, name: str) -> "Parameter":
        """The same under another name."""
        return replace(self, name=name)


@final
@dataclass(frozen=True)
class Parameters:
    """Parameters in a fixed order: the bridge between names and an optimiser's flat vector."""

    items: tuple[Parameter, ...]

    def __add__(self, other: "Parameters") -> "Parameters":
        return Parameters(self.items + other.items)

    def __len__(self) -> int:
        return len(self.items)

    @cached_property
    def names(self) -> tuple[str, ...]:
        """The names, in order."""
        return tuple(item.name for item in self.items)

    @cached_property
    def nominal(self) -> Array:
        """Nominal values, (d,)."""
        return np.array([item.nominal for item in self.items])

    @cached_property
    def lower(self) -> Array:
        """Lower bounds, (d,)."""
        return np.array([item.lower for item in self.items])

    @cached_property
    def upper(self) -> Array:
        """Upper bounds, (d,)."""
        return np.array([item.upper for item in self.items])

    @cached_property
    def width(self) -> Array:
        """Distance between the bounds, (d,): the natural scale of each parameter; a tenth of one that has no room."""
        size = np.where(self.nominal == 0.0, 1.0, FIXED_WIDTH * np.abs(self.nominal))
        return np.where(self.upper > self.lower, self.upper - self.lower, size)

    def values(self, x: Array) -> Values:
        """Unpack candidates (c, d) into one array (c,) for each name."""
        return {name: x[:, column] for column, name in enumerate(self.names)}

    def unbounded(self, names: Iterable[str]) -> tuple[str, ...]:
        """The named ones without given bounds."""
        return tuple(name for name in names if not self.items[self.names.index(name)].given)

    def without(self, names: Iterable[str]) -> "Parameters":
        """All but the named ones."""
        gone = set(names)
        return Parameters(tuple(item for item in self.items if item.name not in gone))

    def columns(self, names: Iterable[str]) -> list[int]:
        """Indices of the named parameters in the flat vector."""
        return [self.names.index(name) for name in names]
