"""The children of a generation in one loop: the compiled twin of `robolaser.algorithms.offspring`, to the last bit."""

import numpy as np

from robolaser.arrays import Array, Bools
from robolaser.compiled.decorators import compiled_exactly


@compiled_exactly
def make_offspring(
    X: Array,
    weights: Array,
    at: Array,
    crossed: Bools,
    share: Array,
    moved: Bools,
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
    slots = np.searchsorted(wheel, at * wheel[-1], side="right")
    Y, genes, moves = np.empty((2 * n, d)), np.empty(d, np.int64), 0
    for i in range(2 * n):
        pair, second = i % n, i // n
        mother, father, child = X[slots[pair, second]], X[slots[pair, 1 - second]], Y[i]
        if crossed[pair]:
            part, rest = share[pair], 1.0 - share[pair]
            for j in range(d):
                a, b = mother[j], father[j]
                child[j] = _within(part * a + rest * b, min(a, b), max(a, b))
        else:
            for j in range(d):
                child[j] = mother[j]
        h = 0
        for j in range(d):
            genes[h] = j  # the next one takes its place if this one stays
            h += moved[i, j]
        if draws[i] <= prob:
            for j in range(d):
                child[j] = _within(child[j], lower[j], upper[j])
            for k in range(h):
                j, move = genes[k], moves + k
                ahead = (upper[j] if upward[move] else lower[j]) - child[j]
                child[j] = _within(child[j] + ahead * steps[move], lower[j], upper[j])
        moves += h
    return Y


@compiled_exactly
def _within(x: float, low: float, high: float) -> float:
    return min(max(x, low), high)


def warm_up() -> None:
    """Compile `make_offspring`."""
    X, one = np.zeros((2, 1)), np.ones(1)
    couple, no, still = np.zeros((1, 2)), np.zeros(1, np.bool_), np.zeros((2, 1), np.bool_)
    make_offspring(X, np.ones(2), couple, no, np.zeros(1), still, no, np.zeros(1), np.zeros(2), 1.0, one, one.copy())
