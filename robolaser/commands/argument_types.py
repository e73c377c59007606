"""Numbers as people type them after an option."""

import argparse
import math

LAST_PORT = 65535
FASTEST = 1000.0


def count(text: str) -> int:
    """A whole number from 1, as typed."""
    return _whole(text, least=1)


def seed(text: str) -> int:
    """A seed, as typed."""
    return _whole(text, least=0)


def port(text: str) -> int:
    """A port of the network, as typed; 0: any that is free."""
    if _whole(text, least=0) > LAST_PORT:
        raise argparse.ArgumentTypeError(f"{text}, expected a port, up to {LAST_PORT}")
    return int(text)


def positive(text: str) -> float:
    """A number above zero, as typed."""
    try:
        number = float(text)
    except ValueError:
        number = math.nan
    if not 0 < number < math.inf:
        raise argparse.ArgumentTypeError(f"{text}, expected a number above 0")
    return number


def hurry(text: str) -> float:
    """How many times faster a clock runs, as typed."""
    if positive(text) > FASTEST:
        raise argparse.ArgumentTypeError(f"{text}, expected a number above 0, up to {FASTEST:g}")
    return float(text)


def _whole(text: str, *, least: int) -> int:
    if not text.isdecimal() or int(text) < least:
        raise argparse.ArgumentTypeError(f"{text}, expected a whole number from {least}")
    return int(text)
