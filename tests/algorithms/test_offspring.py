"""Children keep to their bounds and come from their parents."""

import numpy as np
import pytest
from pymoo.core.problem import Problem

from robolaser.algorithms import RCGA

LOWER, UPPER = np.array([-1.0, 0.0, 5.0, 2.0, -1e-9]), np.array([1.0, 1e6, 5.5, 2.0, 1e-9])


class Uneven(Problem):
    """Variables of very different ranges, one of them without any room."""

    def __init__(self):
        super().__init__(n_var=5, n_obj=1, xl=LOWER, xu=UPPER)

    def _evaluate(self, x, out, *args, **kwargs):
        out["F"] = np.abs(x - LOWER).sum(axis=1)


def generation(seed, outside=0.0, **settings):
    """Parents and their children."""
    room = UPPER - LOWER
    X = np.random.default_rng(seed).uniform(LOWER - outside * room, UPPER + outside * room, (11, 5))
    algorithm = RCGA(pop_size=11, n_elites=0, sampling=X, **settings)
    algorithm.setup(Uneven(), termination=("n_gen", 9), seed=seed)
    algorithm.next()
    algorithm.next()
    return X, algorithm.off.get("X"), algorithm


def test_children_stay_within_bounds():
    for seed in range(1, 51):
        _, Y, _ = generation(seed, outside=0.3, prob_var=seed / 50)
        assert np.all((Y >= LOWER) & (Y <= UPPER))


def test_children_who_neither_mix_nor_move_are_their_parents():
    X, Y, _ = generation(1, prob_crossover=0.0, prob_var=0.0)
    for child in Y:
        assert (child == X).all(axis=1).any()


@pytest.mark.parametrize("prob_var", [0.1, 0.9])
def test_without_luck_no_gene_moves(prob_var):
    _, _, algorithm = generation(2, prob_crossover=0.0, prob_var=prob_var)
    algorithm.mating.mutation.prob.value = 0.0
    parents = algorithm.pop.get("X")
    algorithm.next()
    assert all((child == parents).all(axis=1).any() for child in algorithm.off.get("X"))
