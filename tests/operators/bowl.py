"""A problem with every kind of bounds, populations in it, and an algorithm that knows its time."""

from types import SimpleNamespace

import numpy as np
from pymoo.core.population import Population
from pymoo.core.problem import Problem
from pymoo.core.termination import NoTermination

LOWER = np.array([-1.0, 0.0, 5.0, 2.0, -1e-9])
UPPER = np.array([1.0, 1e6, 5.5, 2.0, 1e-9])


class Bowl(Problem):
    """Squares of the distances to the middle, in units of the bounds; the fourth variable has no room."""

    def __init__(self, n_obj=1, shift=0.0):
        super().__init__(n_var=5, n_obj=n_obj, xl=LOWER, xu=UPPER)
        self.shift = shift

    def _evaluate(self, X, out, *args, **kwargs):
        y = (X - LOWER) / np.where(UPPER > LOWER, UPPER - LOWER, 1.0)
        out["F"] = np.stack([((y - 0.3 * i - 0.2) ** 2).sum(axis=1) for i in range(self.n_obj)], axis=1) + self.shift


def population(problem, n, seed=0):
    """Uniform in the bounds, evaluated, some on the bounds."""
    rng = np.random.default_rng(seed)
    X = rng.uniform(problem.xl, problem.xu, (n, problem.n_var))
    X = np.where(rng.random(X.shape) < 0.1, problem.xl, np.where(rng.random(X.shape) < 0.1, problem.xu, X))
    return Population.new(X=X, F=problem.evaluate(X, return_values_of=["F"]))


def running(n_iter, termination=None):
    """As much of an algorithm as an operator may look at."""
    return SimpleNamespace(n_iter=n_iter, termination=NoTermination() if termination is None else termination)
