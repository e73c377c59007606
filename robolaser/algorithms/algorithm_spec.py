"""The specification of an algorithm: `NAME` or `package.module:attribute`, then `:key=value` for each setting."""

from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import Self, final

from robolaser.algorithms.settings import Value, read
from robolaser.errors import UsageError


@final
@dataclass(frozen=True)
class AlgorithmSpec:
    """What a text specifies."""

    text: str  # as typed
    name: str  # name of the algorithm, or the module that holds it
    attribute: str | None = None  # its name in that module; None for one of ours
    settings: Mapping[str, Value] = field(default_factory=dict)  # the algorithm's settings

    @property
    def path(self) -> str:
        """The text without settings."""
        return self.name if self.attribute is None else f"{self.name}:{self.attribute}"

    @classmethod
    def of(cls, text: str) -> Self:
        """Parse a text.

        Raises:
            UsageError: A part of it is neither a name nor a setting, or a setting is given twice.
        """
        name, *parts = (part.strip() for part in text.split(":"))
        attribute = parts.pop(0) if parts and "=" not in parts[0] else None
        if not name or "=" in name or attribute == "":
            raise malformed(text, "a name is missing")
        settings: dict[str, Value] = {}
        for part in parts:
            key, equals, value = (piece.strip() for piece in part.partition("="))
            if not (key and equals and value):
                raise malformed(text, f"'{part}' is not a setting")
            if key in settings:
                raise malformed(text, f"{key} is given twice")
            settings[key] = read(value)
        return cls(text, name, attribute, settings)


def malformed(text: str, reason: str) -> UsageError:
    """A text does not specify an algorithm."""
    return UsageError(
        f"'{text}' cannot be read: {reason}. Expected NAME or package.module:attribute,"
        " and :key=value after it for each setting, as in rcga:b=2:pop_size=50."
    )
