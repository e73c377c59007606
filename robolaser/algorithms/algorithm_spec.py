"""An algorithm as it is asked for: `NAME`, `package.module:attribute`, and `:key=value` for each setting after it."""

from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import Self, final

from robolaser.algorithms.settings import Value, read
from robolaser.errors import RequestUnreadable


@final
@dataclass(frozen=True)
class Request:
    """What a text asks for.

    Attributes:
        text: As typed.
        name: Of the algorithm, or the module that it is in.
        attribute: Under which the module has it; None for one of ours.
        settings: Of the algorithm.
    """

    text: str
    name: str
    attribute: str | None = None
    settings: Mapping[str, Value] = field(default_factory=dict)

    @classmethod
    def of(cls, text: str) -> Self:
        """Read it.

        Raises:
            RequestUnreadable: A part of it is neither a name nor a setting, or a setting is given twice.
        """
        name, *parts = (part.strip() for part in text.split(":"))
        attribute = parts.pop(0) if parts and "=" not in parts[0] else None
        if not name or "=" in name or attribute == "":
            raise RequestUnreadable(text, "a name is missing")
        settings: dict[str, Value] = {}
        for part in parts:
            key, equals, value = (piece.strip() for piece in part.partition("="))
            if not (key and equals and value):
                raise RequestUnreadable(text, f"'{part}' is no setting")
            if key in settings:
                raise RequestUnreadable(text, f"{key} is given twice")
            settings[key] = read(value)
        return cls(text, name, attribute, settings)
