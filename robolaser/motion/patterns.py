"""Patterns of errors over an arm's motion: an error with a pattern has a cause, and noise has none."""

from dataclasses import dataclass
from functools import cached_property
from typing import final

import numpy as np
from scipy.special import chdtrc

from robolaser.arrays import Array, Ints
from robolaser.motion.evidence import BY_CHANCE, independent_values

BINS = 12  # ranges of a coordinate, each with as many rows. A judgement
FINE = 4 * BINS  # ranges of a joint's posture, over which gears and motors have waves. A judgement
LEAST_SHOWN = 0.05  # share of the residual squares that a coordinate must explain to be named. A judgement
HIDDEN = 0.2
"""Share of the residual squares that undetected patterns may explain where errors count as noise. A judgement."""


@final
@dataclass(frozen=True, eq=False)
class Patterns:
    """Coordinates of rows, along which errors may have patterns."""

    run: Ints  # of each row, (n,)
    time_s: Array  # of each row, (n,) [s]
    posture: Array  # commanded or measured angles, (n, j) [rad]
    load: Array  # torque of gravity, or of the rigid arm, (n, j) [Nm]
    size_by_speed_only: bool = False  # the noise of torques is that of accelerations: by inertia, and so by posture

    def coordinate(self, left: Array, joint: int) -> str:
        """The coordinate along which residuals (n,) of a joint have a pattern; "" where none shows one."""
        speed = self._speed[:, joint]
        own = {
            "speed": np.abs(speed), "direction": np.sign(speed), "load": self.load[:, joint],
            "posture": self.posture[:, joint], "time": self.time_s,
        }  # fmt: skip
        there = np.isfinite(left)
        shares = {name: _explained(left[there], _bins(values[there], BINS)) for name, values in own.items()}
        best = max(shares, key=shares.__getitem__)
        return best if shares[best] > LEAST_SHOWN else ""

    def is_noise(self, left: Array, joint: int) -> bool:
        """Whether neither residuals (n,) of a joint nor their sizes depend on any joint's motion, nor on the time.

        With the effective sample size, the shares that means over ranges explain follow chi-square, over all
        coordinates together. False where a pattern with a fifth of the residuals would not be detected.
        """
        there = np.isfinite(left)
        size = np.abs(left[there]) - np.abs(left[there]).mean()
        fine = ("posture", _bins(self.posture[there, joint], FINE))
        coordinates = [fine, *((name, bins[there]) for name, bins in self._coarse)]
        of_size = [one for one in coordinates if one[0] == "speed" or not self.size_by_speed_only]
        found, hidden = [], []
        for values, tried in ((left[there], coordinates), (size, of_size)):
            count = independent_values(values, self.run[there])
            found += [chdtrc(bins.max() + 1.0, count * _explained(values, bins)) for _, bins in tried]
            hidden.append(chdtrc(float(BINS), HIDDEN * count))
        return bool(len(found) * max(hidden) < BY_CHANCE < len(found) * min(found))

    def _rate(self, values: Array) -> Array:
        """Derivatives of values (n, j) by time [1/s]."""
        return np.asarray(np.gradient(values, axis=0) / np.maximum(np.gradient(self.time_s), 1e-6)[:, None])

    @cached_property
    def _speed(self) -> Array:
        speed = self._rate(self.posture)
        speed[np.flatnonzero(np.diff(self.run)) + 1] = 0.0
        return speed

    @cached_property
    def _coarse(self) -> list[tuple[str, Ints]]:
        """Ranges of every joint's coordinates, and of the time."""
        moved = {"posture": self.posture, "speed": self._speed, "load": self.load}
        moved["acceleration"] = self._rate(self._speed)
        each = [(name, column) for name, values in moved.items() for column in values.T]
        return [(name, _bins(column, BINS)) for name, column in (*each, ("time", self.time_s))]


def _bins(values: Array, count: int) -> Ints:
    """Ranges of equal numbers of values, (n,) -> (n,)."""
    ends = np.unique(np.quantile(values, np.linspace(0.0, 1.0, count + 1)))
    if len(ends) < 3:
        ends = np.array([values.min() - 1e-9, values.mean(), values.max() + 1e-9])
    return np.clip(np.searchsorted(ends, values, side="right") - 1, 0, len(ends) - 2).astype(np.int64)


def _explained(left: Array, bins: Ints) -> float:
    """Share of the squares that means over ranges of a coordinate explain."""
    sums, counts = np.bincount(bins, left), np.maximum(np.bincount(bins), 1)
    return float((sums**2 / counts).sum() / max(float(left @ left), 1e-30))
