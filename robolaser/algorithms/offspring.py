"""Offspring of the genetic algorithm on arrays: roulette wheel, arithmetic crossover, non-uniform mutation."""

import numpy as np

from robolaser.arrays import Array, Bools
from robolaser.operators.arithmetic_crossover import arithmetic
from robolaser.operators.non_uniform_mutation import non_uniform
from robolaser.operators.roulette_selection import roulette_wheel


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
    """Children of n pairs of parents, (2n, d): the first child of each pair, then the second ones.

    Args:
        X: Possible parents, (m, d).
        weights: Widths of their slots on the roulette wheel, (m,).
        at: Where the wheel stops for the two parents, from 0 to 1, (n, 2).
        crossed: Pairs that are crossed; the children of the others are copies, (n,).
        share: Share λ of the first parent in the first child, (n,).
        moved: Genes that mutate, h of them, (2n, d).
        upward: Which of these, row by row, move towards the upper bound, (h,).
        steps: Step sizes, as shares of the distance to the bound, (h,).
        draws: Random draws; children whose draw is at most `prob` mutate at all, (2n,).
        prob: Probability that a child mutates at all.
        lower: Bounds, (d,).
        upper: Bounds, (d,).
    """
    n, d = len(at), X.shape[1]
    Y = parents = X.take(roulette_wheel(weights, at).T, 0)
    if crossed.any():
        Y = arithmetic(parents, share[:, None])
        np.copyto(Y, parents, where=~crossed[:, None])
    Y = Y.reshape(2 * n, d)
    mutants = np.minimum(np.maximum(Y, lower), upper)
    mutated = moved.reshape(-1).nonzero()[0]
    genes, gene = mutants.reshape(-1), mutated % d
    genes[mutated] = non_uniform(genes[mutated], lower[gene], upper[gene], upward, steps)
    return mutants if prob >= 1.0 else np.where(draws[:, None] <= prob, mutants, Y)
