"""Gross errors in a few rows: a reflection taken for the stripe, a reflector mixed up, a ball not seated."""

import numpy as np

from robolaser.arrays import Array, Ints
from robolaser.errors import UsageError
from robolaser.model.effects.outliers import NAME, WHERE

MOST = 0.5  # of the rows: beyond, the gross ones are the rule


def share_of(sizes: dict[str, float]) -> float:
    """Take the share of gross errors out of the effects asked for; 0 where there is none.

    Raises:
        UsageError: It is no share, or more than half.
    """
    share = sizes.pop(f"{NAME}:{WHERE}", 0.0) or sizes.pop(NAME, 0.0)
    if not 0 <= share <= MOST:
        raise impossible(f"share of {NAME}", share, f"a number from 0 to {MOST:g}")
    return share


def impossible(what: str, value: object, expected: str) -> UsageError:
    """The error of a simulated cell that cannot have this."""
    return UsageError(f"A cell cannot be simulated with {what} {value!r}: expected {expected}.")


def gross_rows(count: int, share: float, rng: np.random.Generator) -> tuple[Ints, Array]:
    """A share of so many rows, one at least, and to which side each errs (±1), (g,) and (g,)."""
    if not share:
        return np.empty(0, dtype=np.int64), np.empty(0)
    rows = np.sort(rng.choice(count, size=max(1, round(share * count)), replace=False))
    return rows, rng.choice([-1.0, 1.0], size=len(rows))


def moved_within(value: Array, by: Array, lower: Array | float, upper: Array | float) -> Array:
    """Values moved by some way, or the other way where this one leads out of the bounds."""
    there = value + by
    return np.where((there < lower) | (there > upper), value - by, there)
