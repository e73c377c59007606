"""What a joint does with its commands: a servo with dead time, lag, droop, dead zone, play and limits, along time.

    u = clip((1 + scale) c(t - dead_time) + offset - droop g(c(t - dead_time)), lower, upper)
    dz/dt = clip(D(u - z) / lag, ± speed),  D(e) = sign(e) max(|e| - dead_zone, 0)
    q = z as far as play does not hold it back

Armstrong-Hélouvry, Dupont, Canudas de Wit 1994, A survey of models, analysis tools and compensation methods for the
control of machines with friction; Nordin, Gutman 2002, Controlling mechanical systems with backlash.
"""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import final

import numpy as np

from robolaser.arrays import Array, Ints

IDEAL: Mapping[str, float] = {
    "delay": 0.0, "time": 0.0, "angle": 0.0, "scale": 0.0, "compliance": 0.0, "dead": 0.0, "lost": 0.0,
    "speed": np.inf, "lower": -np.inf, "upper": np.inf,
}  # fmt: skip
"""Numbers of a servo that follows its command."""
SHORTEST_LAG_S = 1e-6
MOST_CELLS = 30_000_000  # simulated at a time


@final
@dataclass(frozen=True, eq=False)
class Runs:
    """Commands as they are simulated, runs side by side, the longest first: (t, s) where the last of each is held."""

    length: Ints  # rows of each run, (s,)
    step: Array  # from each row to the next, (t, s) [s]
    command: Array  # (j, t, s) [rad]
    holding: Array  # torque that holds the arm still where it is commanded, (j, t, s) [Nm]
    start: Array  # where each joint is at the beginning, (j, s) [rad]

    def simulate(self, joint: Ints, numbers: Sequence[Mapping[str, float]]) -> Array:
        """Where joints go whose servos have given numbers.

        Args:
            joint: Of each case, (m,).
            numbers: Of each case, beside those of an ideal servo.

        Returns:
            (t, s, m) [rad].
        """
        rows, runs = self.step.shape
        share = max(1, MOST_CELLS // (rows * runs))
        parts = [
            self._simulated(joint[first : first + share], numbers[first : first + share])
            for first in range(0, len(joint), share)
        ]
        return np.concatenate(parts, axis=2)

    def _simulated(self, joint: Ints, numbers: Sequence[Mapping[str, float]]) -> Array:
        of = {name: np.array([one.get(name, ideal) for one in numbers]) for name, ideal in IDEAL.items()}
        rows, runs = self.step.shape
        wanted = np.empty((rows, runs, len(joint)))
        usual = float(np.median(self.step))
        for m, (j, delay) in enumerate(zip(joint, of["delay"] / usual, strict=True)):
            seen = (1.0 + of["scale"][m]) * self.command[j] + of["angle"][m] - of["compliance"][m] * self.holding[j]
            wanted[:, :, m] = _later(seen, delay)
        np.clip(wanted, of["lower"], of["upper"], out=wanted)
        followed = self.start[joint].T.ravel().copy()
        lost, dead = np.tile(of["lost"], runs), np.tile(of["dead"], runs)
        shown = followed.copy()
        approach = -np.expm1(-self.step[:, :, None] / np.maximum(of["time"], SHORTEST_LAG_S)).reshape(rows, -1)
        fastest = (self.step[:, :, None] * of["speed"]).reshape(rows, -1)
        limited, plays = bool(np.isfinite(of["speed"]).any()), bool(of["lost"].any())
        flat = wanted.reshape(rows, -1)
        off, ignored = np.empty_like(followed), np.empty_like(followed)
        going = np.searchsorted(-self.length, -np.arange(rows), side="left") * len(joint)
        for i, n in enumerate(going.tolist()):  # ufuncs into memory that is there: this loop is most of a diagnosis
            z, e, part = followed[:n], off[:n], ignored[:n]
            np.subtract(flat[i, :n], z, out=e)
            np.maximum(e, -dead[:n], out=part)
            np.minimum(part, dead[:n], out=part)
            e -= part
            e *= approach[i, :n]
            if limited:
                np.maximum(e, -fastest[i, :n], out=e)
                np.minimum(e, fastest[i, :n], out=e)
            z += e
            if plays:
                y = shown[:n]
                np.maximum(y, z - lost[:n], out=y)
                np.minimum(y, z + lost[:n], out=y)
                z = y
            flat[i, :n] = z
        return wanted


def _later(values: Array, rows: float) -> Array:
    """Values (t, s) as they were some rows before, between two of them by a straight line."""
    whole = int(np.floor(rows))
    part = rows - whole
    near = values[np.clip(np.arange(len(values)) - whole, 0, len(values) - 1)]
    if part == 0.0:
        return near
    far = values[np.clip(np.arange(len(values)) - whole - 1, 0, len(values) - 1)]
    return np.asarray((1.0 - part) * near + part * far)
