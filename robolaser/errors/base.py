"""The base of all errors, and how near names are offered."""

import difflib
from collections.abc import Iterable


class RobolaserError(Exception):
    """The data, the robot or a file said no; the message is for a person."""


def near(name: str, known: Iterable[str]) -> str:
    """Name the likeliest meant and all there are: " Did you mean 'tool0'? It has: base, tool0."."""
    names = list(known)
    close = difflib.get_close_matches(name, names, n=1)
    guess = f" Did you mean '{close[0]}'?" if close else ""
    return f"{guess} There are: {', '.join(names) if names else 'none'}."
