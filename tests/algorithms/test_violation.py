"""By how much constraints are violated is what pymoo would reckon."""

import numpy as np
import pytest
from every_problem import Fenced
from pymoo.core.individual import Individual
from pymoo.core.population import Population

from robolaser.algorithms.violation import violation_of


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
    X = np.random.default_rng(1).uniform(problem.xl, problem.xu, (30, problem.n_var))
    said = problem.evaluate(X, return_values_of=["F", "G", "H"], return_as_dictionary=True)
    pop = Population.new(G=said["G"], H=said["H"])
    violation, feasible = violation_of(said)
    assert np.array_equal(violation, pop.get("CV"))
    assert np.array_equal(feasible, pop.get("feas"))
    assert 0 < feasible.sum() < 30
