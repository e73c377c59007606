"""How far two clocks differ that timed one motion: by the angles by which both streams turn."""

from dataclasses import dataclass
from typing import Final, final

import numpy as np
from scipy.optimize import minimize_scalar
from scipy.signal import correlate

from robolaser.arrays import Array
from robolaser.data.importers.time_matching import match
from robolaser.geometry.rigid_motion import log_so3

SPAN_S: Final = 0.3  # over which a turn is measured: long against the noise of one reading, short against a move
FINEST_S: Final = 0.02  # grid of the search
MOST_STEPS: Final = 200_000  # of that grid
ALIKE: Final = 0.8  # agreement of turning speeds, of at most 1, from which both are of one motion: a judgement
PARTS: Final = 20  # of the streams, whose scatter gives the standard error: neighbouring rows share readings
FEWEST: Final = 2 * PARTS  # rows


@final
@dataclass(frozen=True)
class ClockOffset:
    """What to add to the times of one stream to have them by the clock of the other [s]."""

    offset_s: float
    std_s: float

    def __str__(self) -> str:
        """With its standard error."""
        return f"{self.offset_s:.4f} ± {max(self.std_s, 1e-4):.4f} s"


def clock_offset(to_s: Array, T_to: Array, from_s: Array, T_from: Array) -> ClockOffset | None:
    """The offset between the clocks of two bodies that are rigidly connected.

    The angle by which both turn is the same, whatever their frames are. A grid of offsets is searched by the
    agreement of turning speeds; least squares of the angles then refine the best.

    Args:
        to_s: Times of the one by the clock that counts, increasing, (n,).
        T_to: Its poses, (n, 4, 4).
        from_s: Times of the other by its own clock, increasing, (m,).
        T_from: Its poses, (m, 4, 4).

    Returns:
        None where the streams are too short or turn too little, or do not turn alike at any offset.
    """
    if min(len(to_s), len(from_s)) < FEWEST:
        return None
    longest = max(np.ptp(to_s), np.ptp(from_s))
    step = max(float(np.median(np.diff(to_s))), float(np.median(np.diff(from_s))), FINEST_S, longest / MOST_STEPS)
    a, b = (_turns(s, T, np.arange(s[0], s[-1] - step, step), step) for s, T in ((to_s, T_to), (from_s, T_from)))
    energy = correlate(a**2, np.ones_like(b)) + correlate(np.ones_like(a), b**2)
    alike = np.where(energy > 0.5 * energy.max(), 2.0 * correlate(a, b) / np.maximum(energy, 1e-12), 0.0)
    best = int(alike.argmax())
    if alike[best] < ALIKE:
        return None
    start = to_s[0] - from_s[0] + (best - (len(b) - 1)) * step
    span = max(SPAN_S, step)
    at = from_s[from_s < from_s[-1] - span]
    own = _turns(from_s, T_from, at, span)

    def apart(offset: float) -> Array:
        inside = (at + offset >= to_s[0]) & (at + offset + span <= to_s[-1])
        return np.where(inside, _turns(to_s, T_to, at + offset, span) - own, 0.0)

    found = minimize_scalar(
        lambda offset: np.square(apart(offset)).sum(), bounds=(start - step, start + step), method="bounded",
        options={"xatol": 1e-6},
    ).x  # fmt: skip
    slope = (apart(found + 0.1 * step) - apart(found - 0.1 * step)) / (0.2 * step)
    scores = [float(part.sum()) for part in np.array_split(slope * apart(found), PARTS)]
    return ClockOffset(float(found), float(np.sqrt(np.square(scores).sum()) / np.square(slope).sum()))


def _turns(times_s: Array, T: Array, at_s: Array, span_s: float) -> Array:
    """By how much a body turns from each time (k,) within a span [s], (k,) [rad]."""
    R, later = (match(times_s, at, np.inf).motions(T)[:, :3, :3] for at in (at_s, at_s + span_s))
    return np.asarray(np.linalg.norm(log_so3(np.swapaxes(R, -1, -2) @ later), axis=-1))
