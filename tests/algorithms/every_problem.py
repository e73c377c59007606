"""One-objective problems of every kind in pymoo."""

import numpy as np
from pymoo.core.problem import ElementwiseProblem, Problem
from pymoo.problems import get_problem

SPHERE = get_problem("sphere", n_var=6)


class Bowl(Problem):
    """A quadratic with very different ranges of its variables; the last one is fixed."""

    def __init__(self, **kwargs):
        xl, xu = np.array([-1.0, -2.0, 0.0, 3.0]), np.array([1.0, 1e3, 1e-9, 3.0])
        super().__init__(n_var=4, n_obj=1, xl=xl, xu=xu, **kwargs)

    def _evaluate(self, X, out, *args, **kwargs):
        out["F"] = ((X - 0.3) ** 2).sum(axis=1)


class Sunk(Bowl):
    """Negative costs."""

    def _evaluate(self, X, out, *args, **kwargs):
        super()._evaluate(X, out)
        out["F"] -= 100.0


class Holed(Bowl):
    """NaN in one region, infinite in another."""

    def _evaluate(self, X, out, *args, **kwargs):
        super()._evaluate(X, out)
        out["F"] = np.where(X[:, 0] < -0.2, np.nan, np.where(X[:, 1] > 700.0, np.inf, out["F"]))


class Fenced(Bowl):
    """Inequality constraints, and an equality with pymoo's tolerance."""

    def __init__(self):
        super().__init__(n_ieq_constr=3, n_eq_constr=1)

    def _evaluate(self, X, out, *args, **kwargs):
        super()._evaluate(X, out)
        out["G"] = np.stack([0.1 - X[:, 0], X[:, 1] - 500.0, X[:, 0] - X[:, 1]], axis=1)
        out["H"] = (0.5 * X[:, 0] - 0.1)[:, None]


class Telling(Bowl):
    """Returns further outputs, and repairs its candidates."""

    def _evaluate(self, X, out, *args, **kwargs):
        X[:] = np.round(X, 3)
        super()._evaluate(X, out)
        out["X"] = X
        out["length"] = np.linalg.norm(X, axis=1)
        out["square"] = X**2


class OneByOne(ElementwiseProblem):
    """Evaluated one candidate at a time."""

    def __init__(self):
        super().__init__(n_var=3, n_obj=1, n_ieq_constr=1, xl=-1.0, xu=2.0)

    def _evaluate(self, x, out, *args, **kwargs):
        out["F"] = float((x**2).sum())
        out["G"] = 0.5 - x[0]


class Curious(Bowl):
    """Needs the algorithm as an argument."""

    def __init__(self):
        super().__init__(requires_kwargs=True)

    def _evaluate(self, X, out, *args, algorithm, **kwargs):
        super()._evaluate(X, out)
        out["F"] = out["F"] / algorithm.n_gen


ALL = [
    SPHERE, Bowl(), Sunk(), Holed(), Fenced(), Telling(), OneByOne(), Curious(),
    Bowl(replace_nan_values_by=7.0), get_problem("rastrigin", n_var=2), get_problem("g1"),
]  # fmt: skip
