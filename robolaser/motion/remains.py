"""Where what is left lies: at which joint, and along which coordinate of its motion."""

import numpy as np

from robolaser.arrays import Array, Ints

BINS = 12
LEAST_SHARE = 0.05  # of what is left, that a coordinate must show to be named


def coordinate(left: Array, run: Ints, time_s: Array, command: Array, load: Array) -> str:
    """The coordinate along which residuals of a joint have a pattern; "" where none shows one.

    Args:
        left: Residuals, (n,); NaN where there are none.
        run: Of each row, (n,).
        time_s: Of each row, (n,) [s].
        command: Where the joint was sent, or is, (n,) [rad].
        load: Torque that gravity puts on it, (n,) [Nm].
    """
    speed = np.gradient(command) / np.maximum(np.gradient(time_s), 1e-6)
    speed[np.flatnonzero(np.diff(run)) + 1] = 0.0
    coordinates = {
        "speed": np.abs(speed), "direction": np.sign(speed), "load": load, "posture": command, "time": time_s,
    }  # fmt: skip
    there = np.isfinite(left)
    shares = {name: _explained(left[there], values[there]) for name, values in coordinates.items()}
    best = max(shares, key=shares.__getitem__)
    return best if shares[best] > LEAST_SHARE else ""


def _explained(left: Array, values: Array) -> float:
    """Share of the variance that means over ranges of a coordinate explain."""
    ends = np.unique(np.quantile(values, np.linspace(0.0, 1.0, BINS + 1)))
    if len(ends) < 3:
        ends = np.array([values.min() - 1e-9, values.mean(), values.max() + 1e-9])
    bins = np.clip(np.searchsorted(ends, values, side="right") - 1, 0, len(ends) - 2)
    sums = np.bincount(bins, left, len(ends) - 1)
    counts = np.maximum(np.bincount(bins, minlength=len(ends) - 1), 1)
    return float((sums**2 / counts).sum() / max(float(left @ left), 1e-30))
