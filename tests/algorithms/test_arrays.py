"""RCGA goes from array to array, and nobody can tell by what it finds, hands out or counts."""

import copy
import pickle

import numpy as np
import pytest
from pymoo.core.evaluator import Evaluator
from pymoo.core.individual import Individual
from pymoo.core.population import Population
from pymoo.core.problem import ElementwiseProblem, Problem
from pymoo.core.termination import NoTermination
from pymoo.optimize import minimize
from pymoo.problems import get_problem
from pymoo.termination import get_termination
from stock import composed

from robolaser.algorithms import RCGA, CostReached, Stalled

SPHERE = get_problem("sphere", n_var=6)


class Bowl(Problem):
    """A bowl in a box whose last variable has no room."""

    def __init__(self, **kwargs):
        xl, xu = np.array([-1.0, -2.0, 0.0, 3.0]), np.array([1.0, 1e3, 0.0 + 1e-9, 3.0])
        super().__init__(n_var=4, n_obj=1, xl=xl, xu=xu, **kwargs)

    def _evaluate(self, X, out, *args, **kwargs):
        out["F"] = ((X - 0.3) ** 2).sum(axis=1)


class Negative(Bowl):
    def _evaluate(self, X, out, *args, **kwargs):
        out["F"] = (X**2).sum(axis=1) - 10.0


class Holed(Bowl):
    """Not a number here, infinite there."""

    def _evaluate(self, X, out, *args, **kwargs):
        super()._evaluate(X, out)
        out["F"] = np.where(X[:, 0] < -0.2, np.nan, np.where(X[:, 1] > 700.0, np.inf, out["F"]))


class Fenced(Bowl):
    def __init__(self):
        super().__init__(n_ieq_constr=3, n_eq_constr=1)

    def _evaluate(self, X, out, *args, **kwargs):
        super()._evaluate(X, out)
        out["G"] = np.stack([0.1 - X[:, 0], X[:, 1] - 500.0, X[:, 0] - X[:, 1]], axis=1)
        out["H"] = (X[:, 0] - 0.5 * X[:, 0] - 0.1)[:, None]


class Telling(Bowl):
    """Says more than it must, and mends what it is asked about."""

    def _evaluate(self, X, out, *args, **kwargs):
        X[:] = np.round(X, 3)
        super()._evaluate(X, out)
        out["X"] = X
        out["length"] = np.linalg.norm(X, axis=1)
        out["square"] = X**2


class OneByOne(ElementwiseProblem):
    def __init__(self):
        super().__init__(n_var=3, n_obj=1, n_ieq_constr=1, xl=-1.0, xu=2.0)

    def _evaluate(self, x, out, *args, **kwargs):
        out["F"] = float((x**2).sum())
        out["G"] = 0.5 - x[0]


PROBLEMS = [
    SPHERE,
    Bowl(),
    Negative(),
    Holed(),
    Fenced(),
    Telling(),
    OneByOne(),
    Bowl(replace_nan_values_by=7.0),
    get_problem("rastrigin", n_var=2),
    get_problem("g1"),
]
SETTINGS = [
    {"pop_size": 20, "n_elites": 2},
    {"pop_size": 20, "n_elites": 3, "prob_var": 0.5},
    {"pop_size": 15, "n_elites": 0, "form": "power", "b": 2.0},
    {"pop_size": 12, "n_elites": 11, "prob_crossover": 0.0},
    {"pop_size": 13, "n_elites": 4, "prob_crossover": 1.0, "prob_var": 0.0},
    {"pop_size": 2, "n_elites": 1, "last_generation": 7},
]


def columns(pop):
    """All that a population says of itself, not a number counted as infinite."""
    X, F, G, H, CV, born = pop.get("X", "F", "G", "H", "CV", "n_gen")
    return np.hstack([X, np.where(np.isnan(F), np.inf, F), G, H, CV, born[:, None]])


def trail(algorithm, problem, seed, generations=25, termination=("n_gen", 25)):
    """What a run leaves behind, generation by generation."""
    algorithm = copy.deepcopy(algorithm).setup(problem, termination=termination, seed=seed)
    steps = []
    for _ in range(generations):
        algorithm.next()
        steps.append((columns(algorithm.pop), columns(algorithm.off), algorithm.evaluator.n_eval, algorithm.n_iter))
    return steps, algorithm


def assert_same(a, b):
    for one, other in zip(a, b, strict=True):
        assert all(np.array_equal(mine, theirs) for mine, theirs in zip(one, other, strict=True))


@pytest.mark.parametrize("problem", PROBLEMS, ids=lambda problem: type(problem).__name__)
@pytest.mark.parametrize("settings", SETTINGS, ids=lambda settings: f"{settings['pop_size']}-{settings['n_elites']}")
def test_a_run_is_that_of_the_stock_composition_to_the_last_bit(problem, settings):
    for seed in (0, 1):
        ours, theirs = RCGA(**settings).setup(problem, termination=("n_gen", 25), seed=seed), composed(**settings)
        steps, stock = trail(theirs, problem, seed)
        for _ in range(25):
            ours.next()
        assert np.array_equal(columns(ours.pop), steps[-1][0])
        assert np.array_equal(columns(ours.off), steps[-1][1])
        assert ours.evaluator.n_eval == stock.evaluator.n_eval
        assert np.isfinite(ours.opt[0].F).all()


@pytest.mark.parametrize("problem", PROBLEMS, ids=lambda problem: type(problem).__name__)
def test_who_looks_at_every_generation_sees_that_of_the_stock_composition(problem):
    settings = {"pop_size": 14, "n_elites": 3}
    ours, algorithm = trail(RCGA(**settings), problem, 4)
    theirs, stock = trail(composed(**settings), problem, 4)
    assert_same(ours, theirs)
    assert algorithm.opt[0] in list(algorithm.pop)
    for name in ("length", "square"):
        assert np.array_equal(algorithm.pop.get(name), stock.pop.get(name))
    assert all(a.evaluated == b.evaluated for a, b in zip(algorithm.pop, stock.pop, strict=True))
