"""The base of all errors, and how near names are offered."""

import difflib
from collections.abc import Iterable


class RobolaserError(Exception):
    """The data, the robot or a file said no; the message is for a person."""


class WrongUsage(RobolaserError):
    """What was typed has no meaning, whatever the data."""


def near(name: str, known: Iterable[str], most: int | None = None) -> str:
    """Name the likeliest meant and what there is: " Did you mean 'tool0'? There are: base, tool0.".

    Args:
        name: What was written.
        known: What could have been.
        most: How many are listed, the nearest; None: all.
    """
    names = list(known)
    few = names if most is None or len(names) <= most else difflib.get_close_matches(name[:100], names, most, 0.0)
    more = f", and {len(names) - len(few)} more" if len(few) < len(names) else ""
    return f"{meant(name[:100], names)} There are: {', '.join(few) if few else 'none'}{more}."


def meant(name: str, known: Iterable[str]) -> str:
    """Name the likeliest meant, if there is one: " Did you mean 'tool0'?"."""
    names = {known_name.casefold(): known_name for known_name in known}
    close = difflib.get_close_matches(name.casefold(), names, n=1)
    return f" Did you mean '{names[close[0]]}'?" if close else ""
