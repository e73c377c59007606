"""The units that a person stated of a file, and what turns its numbers into SI units."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Final, final

from robolaser.errors import UsageError, near
from robolaser.geometry.units import FACTORS, TIME

NONE: Final = ""  # quantity of pure numbers


@final
@dataclass(frozen=True)
class Units:
    """The units that were stated."""

    stated: Mapping[str, str]  # unit of lengths, angles and times, as far as it was stated

    @classmethod
    def of(cls, names: Sequence[str], option: str = "--units") -> "Units":
        """Read a list of units.

        Args:
            names: Of at most one unit for each quantity.
            option: Or file where they are stated, for messages.

        Raises:
            UsageError: One is unknown, or two are of one quantity.
        """
        stated: dict[str, str] = {}
        for name in names:
            quantity = next((quantity for quantity, factors in FACTORS.items() if name in factors), None)
            if quantity is None:
                raise UsageError(
                    f"{option}: no unit '{name}'.{near(name, [u for known in FACTORS.values() for u in known])}"
                )
            if stated.setdefault(quantity, name) != name:
                raise UsageError(f"{option}: {stated[quantity]} and {name} are both of {quantity}: name one.")
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
                f"In which unit are {quantity}, such as {column}? State it with --units, {example} or another."
            )
        return self.stated[quantity]

    def factor(self, quantity: str, column: str) -> float:
        """What turns a number into metres, radians or seconds."""
        return FACTORS[quantity][self.unit(quantity, column)] if quantity else 1.0
