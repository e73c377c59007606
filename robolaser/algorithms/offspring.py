"""How the genetic algorithm makes children, from array to array: the wheel, the blend and the steps."""

import sys
from collections.abc import Callable
from typing import Any

import numpy as np

from robolaser.arrays import Array, Bools, Ints
from robolaser.compiled import Loops, compiles
from robolaser.operators.arithmetic_crossover import arithmetic
from robolaser.operators.non_uniform_mutation import non_uniform
from robolaser.operators.roulette_selection import spin

_LOOPS = Loops("robolaser.algorithms.offspring_loops", pays_after=0.0)
PAYS_AFTER = 10_000
"""Generations after which a compiled loop has made up for the half second that numba takes to load."""


def brood(
    X: Array,
    weights: Array,
    at: Array,
    crossed: Bools,
    share: Array,
    hit: Ints,
    upward: Bools,
    steps: Array,
    luck: Array,
    prob: float,
    lower: Array,
    upper: Array,
) -> Array:
    """Children of n couples, (2n, d): the first of all, then the second.

    Args:
        X: Those that may be parents, (m, d).
        weights: How wide their slots on the wheel are, (m,).
        at: Where it stops for mothers and fathers, from 0 to 1, (n, 2).
        crossed: Couples that mix; the others' children are their copies, (n,).
        share: What the first child has of its mother, (n,).
        hit: Genes to move, as places in all children's genes, row after row, (h,).
        upward: Which of them move towards the upper bound, (h,).
        steps: By which share of the way to the bound, (h,).
        luck: Children whose genes may move at all have at most `prob` of it, (2n,).
        prob: How many have, from 0 to 1.
        lower: Bounds, (d,).
        upper: Bounds, (d,).
    """
    n, d = len(at), X.shape[1]
    Y = parents = X.take(spin(weights, at).T, 0)
    if crossed.any():
        Y = arithmetic(parents, share[:, None])
        np.copyto(Y, parents, where=~crossed[:, None])
    Y = Y.reshape(2 * n, d)
    mutants = np.minimum(np.maximum(Y, lower), upper)
    genes, gene = mutants.reshape(-1), hit % d
    genes[hit] = non_uniform(genes[hit], lower[gene], upper[gene], upward, steps)
    return mutants if prob >= 1.0 else np.where(luck[:, None] <= prob, mutants, Y)


def loop(generation: int) -> Callable[..., Any]:
    """`brood`, compiled where that has been loaded already or will pay: both give the same children to the last bit."""
    if compiles() == "0" or not (compiles() == "1" or generation > PAYS_AFTER or "numba" in sys.modules):
        return brood
    loops = _LOOPS.after(1.0)
    return loops.brood if loops else brood
