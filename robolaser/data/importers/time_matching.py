"""Readings at the times of measurements: matched within a tolerance and interpolated between the two around each."""

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Final, final

import numpy as np

from robolaser.arrays import Array, Bools, Ints
from robolaser.data.csv_tables import finite
from robolaser.errors import DataError, UsageError
from robolaser.geometry.rigid_motion import exp_so3, log_so3, pose

TOLERANCE: Final = "tolerance_s"  # option that says how far in time a reading may be from a measurement
LONGEST_S = 10.0


@final
@dataclass(frozen=True)
class Match:
    """Where each of m times lies among the times of readings."""

    before: Ints  # number of the reading before, (m,)
    after: Ints  # number of the reading after, (m,); the same at the readings' own time
    share: Array  # of the way from the one to the other, (m,)
    near: Bools  # whether both are within the tolerance, (m,)
    away_s: Array  # how far the nearest reading is, (m,) [s]

    def values(self, readings: Array) -> Array:
        """Readings (n, ...) at the times, linearly between the two, (m, ...)."""
        share = self.share.reshape(-1, *[1] * (readings.ndim - 1))
        return (1 - share) * readings[self.before] + share * readings[self.after]

    def motions(self, T: Array) -> Array:
        """Rigid motions (n, 4, 4) at the times: places between, turns along the shortest way, (m, 4, 4)."""
        R, R_after = T[self.before, :3, :3], T[self.after, :3, :3]
        turn = log_so3(np.swapaxes(R, -1, -2) @ R_after)
        return pose(R @ exp_so3(self.share[:, None] * turn), self.values(T[:, :3, 3]))


def match(readings_s: Array, at_s: Array, tolerance_s: float) -> Match:
    """Match times with those of readings; nothing is extrapolated.

    Args:
        readings_s: Sorted, (n,) [s].
        at_s: (m,) [s].
        tolerance_s: How far the readings before and after may be.
    """
    n = len(readings_s)
    after = np.searchsorted(readings_s, at_s)
    inside = (after < n) & ((after > 0) | (readings_s[np.minimum(after, n - 1)] == at_s))
    after = np.minimum(after, n - 1)
    before = np.maximum(np.where(readings_s[after] == at_s, after, after - 1), 0)
    gap = readings_s[after] - readings_s[before]
    share = np.divide(at_s - readings_s[before], gap, out=np.zeros(len(at_s)), where=gap > 0)
    away = np.stack([np.abs(at_s - readings_s[before]), np.abs(at_s - readings_s[after])])
    near = inside & (away.max(axis=0) <= tolerance_s)
    return Match(before, after, np.clip(share, 0.0, 1.0), near, away.min(axis=0))


def tolerance_of(further: Mapping[str, str], file: str) -> float:
    """The stated tolerance [s].

    Raises:
        UsageError: There is none, or it is no positive number of seconds.
    """
    if TOLERANCE not in further:
        raise UsageError(
            f"{file}: how far in time may a reading of the arm be from a measurement? State it in seconds with"
            f" --set {TOLERANCE}=0.02, for example."
        )
    value = finite(further[TOLERANCE])
    if not 0 < value <= LONGEST_S:
        raise UsageError(f"--set {TOLERANCE}={further[TOLERANCE]}: expected seconds, above 0 and up to {LONGEST_S:g}.")
    return value


def with_readings(
    known: Bools, away_s: Array, tolerance_s: float, *, file: str, what: str, source: str = ""
) -> tuple[Ints, tuple[str, ...]]:
    """Numbers of the measurements that have readings of the arm, and what to say of the others.

    Args:
        known: Whether each has, (m,).
        away_s: How far the nearest reading is, (m,) [s].
        tolerance_s: How far readings may be.
        file: Where measurements are from.
        what: What is measured, in the singular.
        source: Where readings are from.

    Raises:
        DataError: None has any.
    """
    of = f" ({source})" if source else ""
    if not known.any():
        nearest = f"{away_s.min():.3g} s away" if len(away_s) else f"none: there is no {what}"
        raise DataError(
            f"{file}: no {what} has readings of the arm{of} within {tolerance_s:g} s before and after it; the nearest"
            f" is {nearest}. Are the clocks different, or were they recorded at different times?",
            file=file,
        )
    kept = np.flatnonzero(known)
    without = len(known) - len(kept)
    left_out = f"{file}: {without} of {len(known)} {what}s, without readings of the arm within {tolerance_s:g} s"
    return kept, (f"{left_out} before and after",) if without else ()
