"""Units in which people's files state lengths, angles and times, and what turns their numbers into SI units."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Final, final

import numpy as np

from robolaser.errors import UsageError, near

LENGTH: Final = "lengths"
ANGLE: Final = "angles"
TIME: Final = "times"
NONE: Final = ""  # of pure numbers
FACTORS: Mapping[str, Mapping[str, float]] = {
    LENGTH: {"m": 1.0, "cm": 1e-2, "mm": 1e-3, "um": 1e-6, "in": 0.0254},
    ANGLE: {"rad": 1.0, "mrad": 1e-3, "deg": np.pi / 180.0, "arcsec": np.pi / 648_000.0},
    TIME: {"s": 1.0, "ms": 1e-3, "us": 1e-6, "ns": 1e-9},
}
"""Each unit in metres, radians or seconds."""


@final
@dataclass(frozen=True)
class Units:
    """The units that were stated."""

    stated: Mapping[str, str]  # unit of lengths, angles and times, as far as it was stated

    @classmethod
    def of(cls, names: Sequence[str], said: str = "--units") -> "Units":
        """Read a list of units.

        Args:
            names: Of at most one unit for each quantity.
            said: Where they are stated, for messages.

        Raises:
            UsageError: One is unknown, or two are of one quantity.
        """
        stated: dict[str, str] = {}
        for name in names:
            quantity = next((quantity for quantity, factors in FACTORS.items() if name in factors), None)
            if quantity is None:
                raise UsageError(
                    f"{said}: no unit '{name}'.{near(name, [u for known in FACTORS.values() for u in known])}"
                )
            if stated.setdefault(quantity, name) != name:
                raise UsageError(f"{said}: {stated[quantity]} and {name} are both of {quantity}: name one.")
        return cls(stated)

    def unit(self, quantity: str, column: str) -> str:
        """The unit of a quantity; times are in seconds unless it is said otherwise, "" is that of pure numbers.

        Raises:
            UsageError: It was not stated.
        """
        if quantity in (TIME, NONE):
            return self.stated.get(quantity, "s" if quantity else "")
        if quantity not in self.stated:
            example = ", ".join(list(FACTORS[quantity])[:3])
            raise UsageError(
                f"In which unit are {quantity}, such as {column}? Say it with --units, {example} or another."
            )
        return self.stated[quantity]

    def factor(self, quantity: str, column: str) -> float:
        """What turns a number into metres, radians or seconds."""
        return FACTORS[quantity][self.unit(quantity, column)] if quantity else 1.0
