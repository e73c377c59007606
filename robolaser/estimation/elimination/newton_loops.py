"""Newton's method within bounds, compiled: the twin of `elimination.newton`, a problem at a time."""

from typing import Any

import numpy as np

from robolaser.arrays import Array, Ints
from robolaser.compiled.decorators import compiled
from robolaser.estimation.elimination.closures_loops import desk, objective
from robolaser.estimation.elimination.patience import CALM, DONE, FIRM, FIRST, HOPELESS, LOOSE, PIVOTS, STEPS, WORTH


@compiled
def minimise(
    first: int, last: int, problems: Array, zyz: bool, x: Array, lower: Array, upper: Array, size: Array, J: Array
) -> None:
    """Go downhill within bounds.

    Args:
        first: First problem.
        last: The one after the last.
        problems: Rows as `closures` says.
        zyz: Whether the first angle turns about z rather than x.
        x: Where to start, within the bounds, and where each ends, (c, n).
        lower: (c, n).
        upper: (c, n).
        size: What a sum's terms amount to before they cancel, (c,).
        J: Takes the values, (c,).
    """
    room, steps = desk(), stairs(x.shape[1])
    for i in range(first, last):
        J[i] = descend(problems[i], zyz, x[i], lower[i], upper[i], size[i], room, steps)


@compiled
def stairs(n: int) -> Any:
    """Room for the steps of problems with n unknowns."""
    return np.empty((6, n)), np.empty((4, n, n)), np.empty((3, n), dtype=np.int64)


@compiled
def descend(  # noqa: PLR0912 - spelled out for the compiler
    problem: Array, zyz: bool, x: Array, lower: Array, upper: Array, size: float, room: Any, steps: Any
) -> Any:
    """Take one x downhill, and say what is left there."""
    lines, squares, _ = steps
    n = len(x)
    g, g_there, tried, step, low, high = lines[0], lines[1], lines[2], lines[3], lines[4], lines[5]
    H, H_there, curved = squares[0], squares[1], squares[2]
    J = objective(problem, zyz, x, g, H, room)
    damping = 0.0
    for _ in range(STEPS):
        for i in range(n):
            low[i], high[i] = lower[i] - x[i], upper[i] - x[i]
            for j in range(n):
                curved[i, j] = H[i, j]
            curved[i, i] += damping * abs(H[i, i])
        settled = _boxed(curved, g, low, high, step, squares[3], steps[2], tried)
        good = False
        if settled:
            promised = 0.0
            for i in range(n):
                bent = g[i]
                for j in range(n):
                    bent += 0.5 * H[i, j] * step[j]
                promised -= step[i] * bent
                tried[i] = min(max(x[i] + step[i], lower[i]), upper[i])
            whole = size + abs(J)
            if abs(promised) <= DONE * whole:
                for i in range(n):
                    x[i] = tried[i]
                return J - promised
            there = objective(problem, zyz, tried, g_there, H_there, room)
            if promised >= 0.0 and J - there >= WORTH * promised - CALM * whole:
                good = True
                J = there
                for i in range(n):
                    x[i], g[i] = tried[i], g_there[i]
                    for j in range(n):
                        H[i, j] = H_there[i, j]
        if good:
            damping = LOOSE * damping if damping > FIRST else 0.0
        else:
            damping = max(FIRM * damping, FIRST)
            if damping > HOPELESS:
                break
    return J


@compiled
def _boxed(H: Array, g: Array, lower: Array, upper: Array, step: Array, L: Array, marks: Ints, right: Array) -> Any:  # noqa: PLR0912 - spelled out for the compiler
    """As the twin; a part of H that is not positive definite does not settle."""
    n = len(g)
    side, free, to = marks[0], marks[1], marks[2]
    for i in range(n):
        side[i] = 0
        if lower[i] >= upper[i] or (lower[i] >= 0.0 and g[i] > 0.0):
            side[i] = -1
        elif upper[i] <= 0.0 and g[i] < 0.0:
            side[i] = 1
    for _ in range(n + PIVOTS):
        count = 0
        for i in range(n):
            if side[i] == 0:
                free[count] = i
                count += 1
            else:
                step[i] = lower[i] if side[i] < 0 else upper[i]
        for a in range(count):
            i = free[a]
            total = g[i]
            for j in range(n):
                if side[j] != 0:
                    total += H[i, j] * step[j]
            right[a] = -total
            for b in range(a + 1):
                total = H[i, free[b]]
                for c in range(b):
                    total -= L[a, c] * L[b, c]
                if b < a:
                    L[a, b] = total / L[b, b]
                elif total > 0.0:
                    L[a, a] = np.sqrt(total)
                else:
                    return False
        for a in range(count):
            for b in range(a):
                right[a] -= L[a, b] * right[b]
            right[a] /= L[a, a]
        for a in range(count - 1, -1, -1):
            for b in range(a + 1, count):
                right[a] -= L[b, a] * right[b]
            right[a] /= L[a, a]
            step[free[a]] = right[a]
        wrong = False
        for i in range(n):
            to[i] = side[i]
            if lower[i] >= upper[i]:
                continue
            if side[i] == 0:
                to[i] = -1 if step[i] < lower[i] else (1 if step[i] > upper[i] else 0)
            else:
                pull = g[i]
                for j in range(n):
                    pull += H[i, j] * step[j]
                if side[i] * pull > 0.0:
                    to[i] = 0
            wrong = wrong or to[i] != side[i]
        if not wrong:
            return True
        for i in range(n):
            side[i] = to[i]
    return False
