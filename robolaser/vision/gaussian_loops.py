"""Gaussians fitted to the profiles of a stripe, a run of bright pixels at a time."""

import numpy as np

from robolaser.arrays import Array, Bools, Ints
from robolaser.compiled.decorators import compiled
from robolaser.vision.profile_levels import DAMPING, FEWEST, FULL, LONGEST, SETTLED, STEPS, STILL


@compiled
def fit(
    across: Array,
    line: Ints,
    low: Ints,
    high: Ints,
    origin: Ints,
    start: Array,
    full: Bools,
    noise: float,
    centre: Array,
    variance: Array,
) -> None:
    """Fit A exp(-(x - m)² / 2 s²) + c + d x by damped Gauss-Newton steps.

    Args:
        across: The image, (lines, length) [grey, 0 to 255].
        line: Line of each run, (n,).
        low: First pixel to fit, (n,).
        high: Last one, (n,).
        origin: Where x is 0, (n,).
        start: A, m, s, c and d to start from, (n, 5).
        full: Whether the run is saturated; then d stays 0, (n,).
        noise: Variance of a pixel at least.
        centre: Takes m, (n,) [px].
        variance: Takes its variance, 0 where no gaussian fits, (n,) [px²].
    """
    N, r, gaussian = np.empty((5, 5)), np.empty(5), np.empty(5)
    for i in range(len(line)):
        for k in range(5):
            gaussian[k] = start[i, k]
        count, left = 0, 0.0
        step, active = 0, True
        while active:
            active = step < STEPS
            count, left = _equations(across[line[i]], low[i], high[i], origin[i], full[i], gaussian, N, r)
            for k in range(5):
                N[k, k] += (DAMPING if active else SETTLED) * N[k, k] + SETTLED
            _factor(N)
            if active:
                _solve(N, r)
                s = gaussian[2]
                r[1] = min(max(r[1], -s), s)
                r[2] = min(max(r[2], LONGEST[0] * s), LONGEST[1] * s)
                for k in range(5):
                    gaussian[k] += r[k]
                step = step + 1 if max(abs(r[1]), abs(r[2])) > STILL * s else STEPS
        for k in range(5):
            r[k] = 1.0 if k == 1 else 0.0
        _solve(N, r)
        centre[i] = gaussian[1]
        fits = count >= FEWEST and gaussian[0] > 0
        variance[i] = r[1] * max(noise, left / max(count - 5, 1)) if fits else 0.0


@compiled
def _equations(
    row: Array, low: int, high: int, origin: int, full: bool, gaussian: Array, N: Array, r: Array
) -> tuple[int, float]:
    """Write the lower half of the normal equations and their right side; count pixels and what they leave."""
    A, m, s, c, d = gaussian[0], gaussian[1], gaussian[2], gaussian[3], gaussian[4]
    n00 = n10 = n11 = n20 = n21 = n22 = n30 = n31 = n32 = n33 = 0.0
    n40 = n41 = n42 = n43 = n44 = r0 = r1 = r2 = r3 = r4 = rest = 0.0
    count = 0
    tilted = 0.0 if full else 1.0
    z = (low - 1 - origin - m) / s
    following = np.exp(-0.5 * z * z)  # the gaussian from pixel to pixel by products: it is too near to vanish
    ratio, change = np.exp(-(z + 0.5 / s) / s), np.exp(-1 / (s * s))
    for column in range(low, high + 1):
        grey = float(row[column])
        following *= ratio
        ratio *= change
        if grey >= FULL:
            continue
        x = float(column - origin)
        z = (x - m) / s
        g = following
        e = grey - A * g - c - d * x
        shift = A * g * z / s
        spread = shift * z
        x *= tilted
        n00 += g * g
        n10 += shift * g
        n11 += shift * shift
        n20 += spread * g
        n21 += spread * shift
        n22 += spread * spread
        n30 += g
        n31 += shift
        n32 += spread
        n33 += 1.0
        n40 += x * g
        n41 += x * shift
        n42 += x * spread
        n43 += x
        n44 += x * x
        r0 += g * e
        r1 += shift * e
        r2 += spread * e
        r3 += e
        r4 += x * e
        rest += e * e
        count += 1
    N[0, 0], N[1, 0], N[1, 1], N[2, 0], N[2, 1], N[2, 2] = n00, n10, n11, n20, n21, n22
    N[3, 0], N[3, 1], N[3, 2], N[3, 3] = n30, n31, n32, n33
    N[4, 0], N[4, 1], N[4, 2], N[4, 3], N[4, 4] = n40, n41, n42, n43, n44
    r[0], r[1], r[2], r[3], r[4] = r0, r1, r2, r3, r4
    return count, rest


@compiled
def _factor(N: Array) -> None:
    """Cholesky's lower triangle, in place."""
    for i in range(5):
        for j in range(i + 1):
            total = N[i, j]
            for k in range(j):
                total -= N[i, k] * N[j, k]
            N[i, j] = np.sqrt(max(total, 1e-300)) if i == j else total / N[j, j]


@compiled
def _solve(L: Array, r: Array) -> None:
    """Solve L Lᵀ x = r in place."""
    for i in range(5):
        for k in range(i):
            r[i] -= L[i, k] * r[k]
        r[i] /= L[i, i]
    for i in range(4, -1, -1):
        for k in range(i + 1, 5):
            r[i] -= L[k, i] * r[k]
        r[i] /= L[i, i]


def warm_up() -> None:
    """Compile `fit`."""
    numbers, one = np.zeros(1, np.int64), np.zeros(1)
    image = np.zeros((1, 8), np.uint8)
    fit(image, numbers, numbers, numbers, numbers, np.ones((1, 5)), np.zeros(1, np.bool_), 1.0, one, one.copy())
