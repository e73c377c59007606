"""The specification of an algorithm: `NAME` or `package.module:attribute`, then `:key=value` for each setting.

A setting may be an operator, `crossover=NAME` or `crossover=package.module:attribute`, whose own settings follow as
`crossover.prob=0.9`.
"""

from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import Self, final

from robolaser.errors import UsageError

SLOTS = ("sampling", "selection", "crossover", "mutation", "survival", "repair")  # what can be exchanged
Value = int | float | bool | str | None
_WORDS: Mapping[str, Value] = {"true": True, "false": False, "none": None}


@final
@dataclass(frozen=True)
class AlgorithmSpec:
    """The algorithm that a text specifies."""

    text: str  # as typed
    name: str  # of the algorithm, or of the module that holds it
    attribute: str | None = None  # its name in that module; None for one that has a name
    settings: Mapping[str, Value] = field(default_factory=dict)  # its own
    operators: Mapping[str, "AlgorithmSpec"] = field(default_factory=dict)  # those exchanged, by slot

    @property
    def path(self) -> str:
        """The text without settings."""
        return self.name if self.attribute is None else f"{self.name}:{self.attribute}"

    @property
    def stock(self) -> str:
        """The text without exchanged operators."""
        return ":".join([self.path, *(f"{key}={value}" for key, value in self.settings.items())])

    @property
    def values(self) -> Mapping[str, Value]:
        """All settings as typed values, of what has no operators to exchange."""
        return {**self.settings, **{slot: read(one.text) for slot, one in self.operators.items()}}

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
        typed: dict[str, str] = {}
        key = ""
        for part in parts:
            if "=" not in part and key in SLOTS and ":" not in typed[key] and part:
                typed[key] += f":{part}"  # the attribute of an operator's import path
                continue
            key, equals, value = (piece.strip() for piece in part.partition("="))
            if not (key and equals and value):
                raise malformed(text, f"'{part}' is not a setting")
            if key in typed:
                raise malformed(text, f"{key} is given twice")
            typed[key] = value
        operators = {}
        for slot in [slot for slot in SLOTS if slot in typed]:
            own = {key: value for key, value in typed.items() if key.startswith(f"{slot}.")}
            settings = [f"{key.removeprefix(f'{slot}.')}={value}" for key, value in own.items()]
            operators[slot] = cls.of(":".join([typed.pop(slot), *settings]))
            typed = {key: value for key, value in typed.items() if key not in own}
        return cls(text, name, attribute, {key: read(value) for key, value in typed.items()}, operators)


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


def malformed(text: str, reason: str) -> UsageError:
    """The error of a text that specifies no algorithm."""
    return UsageError(
        f"'{text}' cannot be read: {reason}. Expected NAME or package.module:attribute,"
        " and :key=value after it for each setting, as in rcga:b=2:pop_size=50."
    )
