"""From pixels to a scanner's place on the flange in one go, compiled: the twin of `elimination.similarity`."""

from typing import Any

import numpy as np

from robolaser.arrays import Array
from robolaser.compiled.decorators import compiled
from robolaser.estimation.elimination.closures_loops import SIMILARITY, desk
from robolaser.estimation.elimination.newton_loops import descend, stairs
from robolaser.estimation.elimination.patience import WIDE
from robolaser.estimation.elimination.turns_loops import angles_within, turn

SWEEPS = 12  # of Jacobi's rotations over a 4 x 4 matrix; five are usual
STILL = 1e-16  # what is left off the diagonal, of the whole


@compiled
def shown(first: int, last: int, lens: Array, sheet: Array, pixel: Array, along_u: bool, seen: Array) -> None:
    """Points on the sheet that pixels show, in the camera frame: the twin of `optics`.

    Args:
        first: First candidate.
        last: The one after the last.
        lens: s_u, s_v, u_0, v_0, k and f, (c, 6).
        sheet: n · P = d, (c, 1 or m, 4).
        pixel: (m, 2) [px].
        along_u: Whether the stripe runs along image u.
        seen: Takes the points, (c, m, 3) [m]; not finite at poles.
    """
    for i in range(first, last):
        s_u, s_v, u_0, v_0, k, f = lens[i]
        for r in range(len(pixel)):
            at = r if sheet.shape[1] > 1 else 0
            u, v = (pixel[r, 0] - u_0) * s_u, (pixel[r, 1] - v_0) * s_v
            grown = 1.0 + k * (u * u + v * v)
            x, y = (v * grown, -u * grown) if along_u else (u * grown, v * grown)
            rho = sheet[i, at, 3] / (sheet[i, at, 0] * x + sheet[i, at, 1] * y + sheet[i, at, 2] * f)
            seen[i, r, 0], seen[i, r, 1], seen[i, r, 2] = rho * x, rho * y, rho * f


@compiled
def fit(  # noqa: PLR0912 - spelled out for the compiler
    first: int,
    last: int,
    seen: Array,
    known: Array,
    bracket: Array,
    zyz: bool,
    lower: Array,
    upper: Array,
    scale: Array,
    found: Array,
) -> None:
    """The best λ, angles and shift within bounds.

    Args:
        first: First candidate.
        last: The one after the last.
        seen: p, in the camera frame, (c, m, 3) [m].
        known: d, in the flange frame, (c or 1, m, 3) [m].
        bracket: B, (3, 3).
        zyz: Whether the first angle turns about z rather than x.
        lower: Of angles and shift, (6,).
        upper: The same.
        scale: Bounds of λ, (c, 2).
        found: Takes λ, angles and shift, (c, 7); not a number where a point is not finite.
    """
    problem, room, steps = np.empty(SIMILARITY), desk(), stairs(4)
    for i in range(3):
        problem[27 + i], problem[30 + i] = lower[3 + i], upper[3 + i]
        for j in range(3):
            problem[18 + 3 * i + j] = bracket[i, j]
    low, high, x = np.empty(4), np.empty(4), np.empty(4)
    for k in range(3):
        low[1 + k], high[1 + k] = lower[k], upper[k]
    wide = zyz or max(high[1] - low[1], high[2] - low[2], high[3] - low[3]) > WIDE
    K, Q, R, angles = np.empty((4, 4)), np.empty((4, 4)), np.empty((3, 3)), np.empty(3)
    for c in range(first, last):
        _gather(seen[c], known[c if len(known) > 1 else 0], problem)
        found[c] = np.nan
        if not np.isfinite(problem[:18].sum()) or problem[15] == 0.0:
            continue
        _spin(problem, K, Q)
        least = np.inf
        for sign in (1.0, -1.0):
            low[0], high[0] = scale[c, 0], scale[c, 1]
            if sign > 0:
                low[0] = max(low[0], 0.0)
            else:
                high[0] = min(high[0], 0.0)
            if low[0] > high[0] or low[0] == high[0] == 0.0:
                continue
            best = 0
            for i in range(1, 4):
                if sign * K[i, i] > sign * K[best, best]:
                    best = i
            _turned(Q, best, R)
            angles_within(R, zyz, lower[:3], upper[:3], angles)
            ideal = K[best, best] / problem[15]
            fits, near = low[0] <= ideal <= high[0], True
            x[0] = ideal
            for k in range(1, 4):
                x[k] = angles[k - 1]
                near = near and low[k] <= x[k] <= high[k]
            if fits and near and _shift_fits(problem, ideal, R):
                J = problem[16] - ideal * ideal * problem[15]
                if least > J:
                    least = J
                    found[c, :4] = x
                continue
            size = problem[16] + ideal * ideal * problem[15]
            for i in range(3):
                size += problem[17] * (problem[3 + i] ** 2 + ideal * ideal * problem[i] ** 2)
            for start in range(2):
                if start == 0 and not near and not wide:
                    continue
                if start == 1 and near and not wide:
                    continue
                for k in range(4):
                    aim = ideal if k == 0 else (angles[k - 1] if start == 0 else (low[k] + high[k]) / 2)
                    x[k] = min(max(aim, low[k]), high[k])
                J = descend(problem, zyz, x, low, high, size, room, steps)
                if least > J:
                    least = J
                    found[c, :4] = x
        _shift(problem, zyz, found[c], room)


@compiled
def _gather(seen, known, problem):  # type: ignore[no-untyped-def]
    """Moments of a candidate's points."""
    m = np.uintp(seen.shape[0])
    for i in range(18):
        problem[i] = 0.0
    for r in range(m):
        for i in range(3):
            problem[i] += seen[r, i]
            problem[3 + i] += known[r, i]
    for i in range(6):
        problem[i] /= m
    p_0, p_1, p_2, d_0, d_1, d_2 = problem[0], problem[1], problem[2], problem[3], problem[4], problem[5]
    c_00 = c_01 = c_02 = c_10 = c_11 = c_12 = c_20 = c_21 = c_22 = pp = dd = 0.0
    for r in range(m):
        x, y, z = seen[r, 0] - p_0, seen[r, 1] - p_1, seen[r, 2] - p_2
        u, v, w = known[r, 0] - d_0, known[r, 1] - d_1, known[r, 2] - d_2
        c_00, c_01, c_02 = c_00 + u * x, c_01 + u * y, c_02 + u * z
        c_10, c_11, c_12 = c_10 + v * x, c_11 + v * y, c_12 + v * z
        c_20, c_21, c_22 = c_20 + w * x, c_21 + w * y, c_22 + w * z
        pp += x * x + y * y + z * z
        dd += u * u + v * v + w * w
    for i in range(3):
        b_0, b_1, b_2 = problem[18 + i], problem[21 + i], problem[24 + i]
        problem[6 + 3 * i] = b_0 * c_00 + b_1 * c_10 + b_2 * c_20
        problem[7 + 3 * i] = b_0 * c_01 + b_1 * c_11 + b_2 * c_21
        problem[8 + 3 * i] = b_0 * c_02 + b_1 * c_12 + b_2 * c_22
    problem[15], problem[16], problem[17] = pp, dd, m


@compiled
def _spin(problem, K, Q):  # type: ignore[no-untyped-def]
    """Quaternions and how well their turns bring p onto d: eigenvectors, columns of Q, and K's diagonal. Horn 1987."""
    x_x, y_x, z_x = problem[6], problem[7], problem[8]
    x_y, y_y, z_y = problem[9], problem[10], problem[11]
    x_z, y_z, z_z = problem[12], problem[13], problem[14]
    K[0, 0], K[1, 1] = x_x + y_y + z_z, x_x - y_y - z_z
    K[2, 2], K[3, 3] = y_y - x_x - z_z, z_z - x_x - y_y
    K[0, 1], K[0, 2], K[0, 3] = y_z - z_y, z_x - x_z, x_y - y_x
    K[1, 2], K[1, 3], K[2, 3] = x_y + y_x, z_x + x_z, y_z + z_y
    whole = 0.0
    for i in range(4):
        for j in range(4):
            Q[i, j] = 1.0 if i == j else 0.0
            if i > j:
                K[i, j] = K[j, i]
            whole += K[min(i, j), max(i, j)] ** 2
    for _ in range(SWEEPS):
        off = 0.0
        for i in range(3):
            for j in range(i + 1, 4):
                off += K[i, j] ** 2
        if off <= STILL**2 * whole:
            break
        for i in range(3):
            for j in range(i + 1, 4):
                if K[i, j] != 0.0:
                    _rotate(K, Q, i, j)


@compiled
def _rotate(K, Q, i, j):  # type: ignore[no-untyped-def]
    """Jacobi's rotation that clears one pair."""
    theta = (K[j, j] - K[i, i]) / (2 * K[i, j])
    t = 1.0 / (abs(theta) + np.sqrt(theta * theta + 1.0))
    t = -t if theta < 0.0 else t
    c = 1.0 / np.sqrt(t * t + 1.0)
    s = t * c
    for k in range(4):
        a, b = K[k, i], K[k, j]
        K[k, i], K[k, j] = c * a - s * b, s * a + c * b
    for k in range(4):
        a, b = K[i, k], K[j, k]
        K[i, k], K[j, k] = c * a - s * b, s * a + c * b
        a, b = Q[k, i], Q[k, j]
        Q[k, i], Q[k, j] = c * a - s * b, s * a + c * b


@compiled
def _turned(Q, k, R):  # type: ignore[no-untyped-def]
    """The rotation of a quaternion (w, x, y, z)."""
    w, x, y, z = Q[0, k], Q[1, k], Q[2, k], Q[3, k]
    R[0, 0], R[0, 1], R[0, 2] = 1 - 2 * (y * y + z * z), 2 * (x * y - w * z), 2 * (x * z + w * y)
    R[1, 0], R[1, 1], R[1, 2] = 2 * (x * y + w * z), 1 - 2 * (x * x + z * z), 2 * (y * z - w * x)
    R[2, 0], R[2, 1], R[2, 2] = 2 * (x * z - w * y), 2 * (y * z + w * x), 1 - 2 * (x * x + y * y)


@compiled
def _shift_fits(problem, scale, R):  # type: ignore[no-untyped-def]
    """Whether the best shift is within its bounds."""
    for i in range(3):
        wanted = _wanted(problem, scale, R, i)
        if not problem[27 + i] <= wanted <= problem[30 + i]:
            return False
    return True


@compiled
def _wanted(problem, scale, R, i):  # type: ignore[no-untyped-def]
    """The best shift along an axis."""
    moved = 0.0
    for j in range(3):
        for k in range(3):
            moved += problem[18 + 3 * i + j] * R[j, k] * problem[k]
    return problem[3 + i] - scale * moved


@compiled
def _shift(problem: Array, zyz: bool, x: Array, room: Any) -> None:
    """The best shift within its bounds."""
    R, axes = room[0], room[1]
    turn(x[1:4], zyz, R, axes)
    for i in range(3):
        x[4 + i] = min(max(_wanted(problem, x[0], R, i), problem[27 + i]), problem[30 + i])
