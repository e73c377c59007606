"""Torques that saturate where the motion takes more: a motor, or its reading, at its limit."""

from collections.abc import Sequence
from dataclasses import dataclass
from typing import final

import numpy as np
from scipy.special import chdtrc

from robolaser.arrays import Bools
from robolaser.motion.evidence import BY_CHANCE, independent_values
from robolaser.motion.gap import root_mean_squares, white_noise
from robolaser.motion.kind_diagnosis import OVER_NOISE
from robolaser.motion.quantities import Quantities

FEWEST_ROWS = 30  # on either side of a limit. A judgement
ROUNDS = 6  # of the limit by the rows at it, and of these by the limit
NEAR = 6.0
"""Rows within so many times the noise of the largest value are tried first as rows at a limit: noise reaches less."""


@final
@dataclass(frozen=True, eq=False)
class CutOff:
    """Rows of one joint at a limit of its torques."""

    joint: str
    rows: Bools  # (n, j)
    most: float  # the limit, with its sign [Nm]
    wanted: float  # the largest torque that the motion takes there, with its sign [Nm]

    def __str__(self) -> str:
        """A remark for the user."""
        share = self.rows.any(axis=1).mean()
        return (
            f"Torques of {self.joint} are cut off at {self.most:.3g} Nm in {share:.1%} of the rows,"
            f" where the motion takes up to {self.wanted:.3g} Nm: no effect is fitted to these."
        )


def cuts(of: Quantities) -> list[CutOff]:
    """Limits of the torques of all joints."""
    return [one for joint in range(of.q.shape[1]) for one in _cuts_of(of, joint)]


def cut_rows(of: Quantities, limits: Sequence[CutOff]) -> Bools:
    """Which torques are at one of the limits, (n, j)."""
    return np.asarray(np.any([np.zeros(of.q.shape, dtype=bool), *(one.rows for one in limits)], axis=0))


def _cuts_of(of: Quantities, joint: int) -> list[CutOff]:
    """Limits of a joint's torques, at either end.

    The model is the rigid arm with scale and friction, below a limit and at it (a censored regression, Tobin 1958,
    Econometrica 26). At a limit the readings vary by noise only while the motion's torques vary, and the likelihood
    is higher with it.
    """
    there = np.flatnonzero(np.isfinite(of.measured[:, joint]))
    read, direction = of.measured[there, joint], of.direction[there, joint]
    columns = np.stack([of.rigid[there, joint], direction, np.abs(direction), of.speed[there, joint]], axis=1)
    noise = float(white_noise(of.log.tau[:, joint, None], of.log.run, None)[0])
    found = []
    for side in (-1.0, 1.0):
        y = side * read
        at = y > y.max(initial=-np.inf) - NEAR * noise
        wanted, most = y, np.inf  # on this side, limits are the largest values
        for _ in range(ROUNDS):
            if min(at.sum(), (~at).sum()) >= FEWEST_ROWS:
                wanted, most = columns @ np.linalg.lstsq(columns[~at], y[~at])[0], float(y[at].mean())
                at = wanted > most
        if min(at.sum(), (~at).sum()) < FEWEST_ROWS:
            continue
        left = y - np.minimum(wanted, most)
        straight = y - columns @ np.linalg.lstsq(columns, y)[0]
        gain = independent_values(left, of.run[there]) * float(np.log((straight @ straight) / (left @ left)))
        over, flat, below = map(root_mean_squares, (wanted[at] - most, left[at], left[~at]))
        if chdtrc(1.0, max(gain, 0.0)) < BY_CHANCE and over > OVER_NOISE * flat and flat < OVER_NOISE * below:
            rows = np.zeros(of.q.shape, dtype=bool)
            rows[there[at], joint] = True
            found.append(CutOff(of.log.joints[joint], rows, side * most, side * float(wanted.max())))
    return found
