"""What a problem says is what pymoo would hear, and by how much it is violated what pymoo would reckon."""

import numpy as np
import pytest
from every_problem import ALL, Bowl, Fenced
from pymoo.core.individual import Individual
from pymoo.core.population import Population
from pymoo.core.problem import Problem

from robolaser.algorithms.evaluation import evaluated
from robolaser.algorithms.violation import violation_of

NAMES = ["F", "G", "H"]


class Told:
    """As much of an algorithm as a problem may look at."""

    n_gen = 3


class Integers(Bowl):
    def _evaluate(self, X, out, *args, **kwargs):
        out["F"] = np.round(X[:, 0]).astype(int)


class Lists(Bowl):
    def _evaluate(self, X, out, *args, **kwargs):
        out["F"] = [list(X[:, 1])]


class Silent(Bowl):
    def _evaluate(self, X, out, *args, **kwargs):
        out["word"] = np.array(["yes"] * len(X), dtype=object)


class Detour(Bowl):
    def do(self, X, return_values_of, *args, **kwargs):
        return {name: -value for name, value in super().do(X, return_values_of, *args, **kwargs).items()}


def candidates(problem, n=7):
    return np.random.default_rng(1).uniform(problem.xl, problem.xu, (n, problem.n_var))


def replaced():
    problem = Bowl()
    problem._evaluate = lambda X, out, *args, **kwargs: out.update(F=X[:, 2])
    return problem


EVERY = [*ALL, Integers(), Lists(), Silent(), Detour(), replaced()]


@pytest.mark.parametrize("problem", EVERY, ids=lambda problem: type(problem).__name__)
def test_a_problem_says_what_it_says_to_pymoo(problem):
    X = candidates(problem)
    ours = evaluated(problem, X.copy(), NAMES, Told)
    theirs = problem.evaluate(X.copy(), return_values_of=NAMES, return_as_dictionary=True, algorithm=Told)
    assert all(name in ours or not theirs[name].size for name in theirs)
    for name, value in ours.items():
        assert value.dtype == theirs[name].dtype
        assert value.shape == theirs[name].shape
        assert all(a == b or a != a for a, b in zip(value.ravel(), theirs[name].ravel(), strict=True))


def test_what_a_problem_keeps_is_not_what_it_gave_away():
    class Keeping(Bowl):
        def _evaluate(self, X, out, *args, **kwargs):
            self.F = out["F"] = X[:, 0]

    problem = Keeping()
    said = evaluated(problem, candidates(problem), NAMES, Told)
    problem.F[:] = 0.0
    assert np.all(said["F"] != 0.0)


def test_a_problem_that_says_too_little_is_told_so_as_by_pymoo():
    class Short(Problem):
        def _evaluate(self, X, out, *args, **kwargs):
            out["F"] = np.zeros(3)

    problem = Short(n_var=2, n_obj=1, xl=0.0, xu=1.0)
    with pytest.raises(Exception, match="F can not be set"):
        evaluated(problem, candidates(problem), NAMES, Told)


@pytest.mark.parametrize("n_constraints", [(0, 3), (5, 0), (1, 1), (17, 9)])
def test_violation_is_what_pymoos_individuals_reckon(n_constraints):
    rng = np.random.default_rng(2)
    said = {name: rng.normal(0.0, 10.0, (40, n)) for name, n in zip("GH", n_constraints, strict=True) if n}
    said = {name: value * (rng.random(value.shape) < 0.3) for name, value in said.items()}
    pop = Population.new(**said)
    violation, feasible = violation_of(said)
    assert np.array_equal(violation, pop.get("CV"))
    assert np.array_equal(feasible, pop.get("feas"))


def test_violation_follows_pymoos_settings(monkeypatch):
    def config():
        return {
            "cache": True,
            "cv_eps": 0.5,
            "cv_ieq": {"scale": 2.0, "eps": 0.1, "pow": 2, "func": np.mean},
            "cv_eq": {"scale": None, "eps": 0.2, "pow": None, "func": np.sum},
        }

    monkeypatch.setattr(Individual, "default_config", config)
    problem = Fenced()
    said = evaluated(problem, candidates(problem, 30), NAMES, Told)
    pop = Population.new(G=said["G"], H=said["H"])
    violation, feasible = violation_of(said)
    assert np.array_equal(violation, pop.get("CV"))
    assert np.array_equal(feasible, pop.get("feas"))
    assert 0 < feasible.sum() < 30
