"""The children of a generation in one loop: the compiled twin of `robolaser.algorithms.offspring`, to the last bit."""

import numpy as np

from robolaser.arrays import Array, Bools, Ints
from robolaser.compiled.decorators import compiled_exactly


@compiled_exactly
def make_offspring(
    X: Array,
    weights: Array,
    at: Array,
    crossed: Bools,
    share: Array,
    mutated: Ints,
    upward: Bools,
    steps: Array,
    draws: Array,
    prob: float,
    lower: Array,
    upper: Array,
) -> Array:
    """Children of pairs; see the twin for the arguments."""
    n, d = len(at), X.shape[1]
    wheel = np.cumsum(weights)
    Y = np.empty((2 * n, d))
    for i in range(n):
        mother = np.searchsorted(wheel, at[i, 0] * wheel[-1], side="right")
        father = np.searchsorted(wheel, at[i, 1] * wheel[-1], side="right")
        for j in range(d):
            a, b = X[mother, j], X[father, j]
            if crossed[i]:
                low, high, rest = min(a, b), max(a, b), 1.0 - share[i]
                a, b = _within(share[i] * a + rest * b, low, high), _within(share[i] * b + rest * a, low, high)
            Y[i, j], Y[n + i, j] = a, b
    for i in range(2 * n):
        if draws[i] <= prob:
            for j in range(d):
                Y[i, j] = _within(Y[i, j], lower[j], upper[j])
    for k in range(len(mutated)):
        i, j = divmod(mutated[k], d)
        if draws[i] <= prob:
            ahead = (upper[j] if upward[k] else lower[j]) - Y[i, j]
            Y[i, j] = _within(Y[i, j] + ahead * steps[k], lower[j], upper[j])
    return Y


@compiled_exactly
def _within(x: float, low: float, high: float) -> float:
    return min(max(x, low), high)


def warm_up() -> None:
    """Compile `make_offspring`."""
    X, one = np.zeros((2, 1)), np.ones(1)
    couple, mutated, no = np.zeros((1, 2)), np.zeros(1, np.int64), np.zeros(1, np.bool_)
    make_offspring(X, np.ones(2), couple, no, np.zeros(1), mutated, no, np.zeros(1), np.zeros(2), 1.0, one, one.copy())
