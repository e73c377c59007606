"""An operator that breaks the contract is told in which way."""

import numpy as np
import pytest
from pymoo.algorithms.soo.nonconvex.ga import comp_by_cv_and_fitness
from pymoo.core.crossover import Crossover
from pymoo.core.mutation import Mutation
from pymoo.core.selection import Selection
from pymoo.operators.crossover.sbx import SBX
from pymoo.operators.mutation.pm import PM
from pymoo.operators.selection.tournament import TournamentSelection

from robolaser.errors import AlgorithmError
from robolaser.operators.testing import MISSING, STOCK_ALGORITHMS, WORKS, check_operator


class Shuffling(Crossover):
    """A whole crossover, to be broken in one way at a time."""

    def __init__(self):
        super().__init__(2, 2, prob=1.0)

    def _do(self, problem, X, *args, random_state=None, **kwargs):
        return X[random_state.permutation(2)]


class ForgetsItsSeed(Shuffling):
    def _do(self, problem, X, *args, **kwargs):
        return X[np.random.default_rng().permutation(2)] * np.random.default_rng().random()


class LeavesTheBox(Shuffling):
    def _do(self, problem, X, *args, **kwargs):
        return 2.0 * X - X[::-1]


class Overwrites(Mutation):
    def do(self, problem, pop, inplace=True, **kwargs):
        for one in pop:
            one.X[:] = problem.xl
        return pop


class SelectsOne(Selection):
    def _do(self, problem, pop, n_select, n_parents, **kwargs):
        return np.zeros(n_select, int)


class Breaks(Shuffling):
    def _do(self, problem, X, *args, **kwargs):
        return X.nothing


@pytest.mark.parametrize(
    ("operator", "way"),
    [
        (ForgetsItsSeed, "another outcome with the same seed"),
        (LeavesTheBox, "leaves the bounds, in variable 0"),
        (Overwrites, "changes the parents"),
        (SelectsOne, r"selects an array \(10,\)"),
        (Breaks, "failed where it was tried: AttributeError"),
    ],
)
def test_each_broken_law_has_its_sentence(operator, way):
    with pytest.raises(AlgorithmError, match=f"(?s){operator.__name__} .*{way}"):
        check_operator(operator(), algorithms=())


def test_what_is_no_operator_is_refused():
    with pytest.raises(AlgorithmError, match="not an operator"):
        check_operator(lambda: None)


@pytest.mark.parametrize("operator", [SBX(), PM(), Shuffling()], ids=["SBX", "PM", "ours"])
def test_whole_operators_pass_and_serve(operator):
    found = check_operator(operator, algorithms=("GA", "NSGA2"))
    assert found.algorithms["NSGA2"] == (WORKS, "")
    assert "keeps to the contract" in str(found)


def test_the_default_selection_of_pymoos_genetic_algorithm_passes():
    found = check_operator(TournamentSelection(func_comp=comp_by_cv_and_fitness), algorithms=("GA",))
    assert found.algorithms["GA"] == (WORKS, "")


def test_an_algorithm_whose_package_is_missing_is_not_one_without_a_place(monkeypatch):
    monkeypatch.setitem(STOCK_ALGORITHMS, "KGB", ("moo.not_there", {}))
    found = check_operator(SBX(), algorithms=("KGB",))
    assert found.algorithms["KGB"] == (MISSING, "No module named 'pymoo.algorithms.moo.not_there'")
