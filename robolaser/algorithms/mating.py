"""How the genetic algorithm makes children, from array to array: the wheel, the blend and the shrinking steps."""

from collections.abc import Callable

import numpy as np

from robolaser.arrays import Array
from robolaser.operators.arithmetic_crossover import arithmetic
from robolaser.operators.non_uniform_mutation import non_uniform
from robolaser.operators.roulette_selection import fitness, spin


def children(
    X: Array,
    J: Array,
    n_pairs: int,
    rng: np.random.Generator,
    *,
    lower: Array,
    upper: Array,
    prob_crossover: float,
    prob_var: float,
    prob: float,
    share: Callable[[Array], Array],
) -> Array:
    """Mate parents (n, d) of costs (n,): two children a pair, (2 n_pairs, d), all the first before all the second.

    What pymoo makes of `RouletteSelection`, `ArithmeticCrossover` and `NonUniformMutation`, to the last bit.

    Args:
        X: Parents.
        J: Their costs.
        n_pairs: Pairs to mate.
        rng: Draws, in the order that `RCGA` documents.
        lower: Bounds, (d,).
        upper: Bounds, (d,).
        prob_crossover: Probability that a pair is crossed.
        prob_var: Probability that a gene is moved.
        prob: Probability that a child may be mutated.
        share: Turns uniform draws into steps, as shares of the distance to the bound.
    """
    d = X.shape[1]
    wheel_and_coins = rng.random(3 * n_pairs)
    couples = spin(fitness(J), wheel_and_coins[: 2 * n_pairs].reshape(n_pairs, 2))
    crossed = wheel_and_coins[2 * n_pairs :] < prob_crossover
    Y = parents = X.take(couples.T, 0)
    if crossed.any():
        Y = arithmetic(parents, rng.random((n_pairs, 1)))
        np.copyto(Y, parents, where=~crossed[:, None])
    Y = Y.reshape(2 * n_pairs, -1)

    hit = (rng.random(Y.size) < prob_var).nonzero()[0]
    h = len(hit)
    draws = rng.random(2 * h + len(Y))
    mutants = np.minimum(np.maximum(Y, lower), upper)
    gene = hit % d
    genes = mutants.reshape(-1)
    genes[hit] = non_uniform(genes[hit], lower[gene], upper[gene], draws[:h] < 0.5, share(draws[h : 2 * h]))
    if prob >= 1.0:
        return mutants
    return np.where(draws[2 * h :, None] <= prob, mutants, Y)
