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
        mother = X[np.searchsorted(wheel, at[i, 0] * wheel[-1], side="right")]
        father = X[np.searchsorted(wheel, at[i, 1] * wheel[-1], side="right")]
        one, other = Y[i], Y[n + i]
        if crossed[i]:
            part, rest = share[i], 1.0 - share[i]
            for j in range(d):
                a, b = mother[j], father[j]
                low, high = min(a, b), max(a, b)
                one[j], other[j] = _within(part * a + rest * b, low, high), _within(part * b + rest * a, low, high)
        else:
            one[:], other[:] = mother, father
        for child, draw in ((one, draws[i]), (other, draws[n + i])):
            if draw <= prob:
                for j in range(d):
                    child[j] = _within(child[j], lower[j], upper[j])
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
