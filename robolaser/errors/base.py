"""The base of all errors, and how near names are offered."""

import difflib
from collections.abc import Iterable


class RobolaserError(Exception):
    """The data, the robot or a file said no; the message is for a person."""


class WrongUsage(RobolaserError):
    """What was typed has no meaning, whatever the data."""


def near(name: str, known: Iterable[str]) -> str:
    """Name the likeliest meant and all there are: " Did you mean 'tool0'? It has: base, tool0."."""
    names = list(known)
    return f"{meant(name, names)} There are: {', '.join(names) if names else 'none'}."


def meant(name: str, known: Iterable[str]) -> str:
    """Name the likeliest meant, if there is one: " Did you mean 'tool0'?"."""
    names = {known_name.casefold(): known_name for known_name in known}
    close = difflib.get_close_matches(name.casefold(), names, n=1)
    return f" Did you mean '{names[close[0]]}'?" if close else ""
