"""Problems of every kind that pymoo knows with one objective."""

import numpy as np
from pymoo.core.problem import ElementwiseProblem, Problem
from pymoo.problems import get_problem

SPHERE = get_problem("sphere", n_var=6)


class Bowl(Problem):
    """A bowl in a box of very different sides; the last variable has no room."""

    def __init__(self, **kwargs):
        xl, xu = np.array([-1.0, -2.0, 0.0, 3.0]), np.array([1.0, 1e3, 1e-9, 3.0])
        super().__init__(n_var=4, n_obj=1, xl=xl, xu=xu, **kwargs)

    def _evaluate(self, X, out, *args, **kwargs):
        out["F"] = ((X - 0.3) ** 2).sum(axis=1)


class Sunk(Bowl):
    """Costs below 0."""

    def _evaluate(self, X, out, *args, **kwargs):
        super()._evaluate(X, out)
        out["F"] -= 100.0


class Holed(Bowl):
    """Not a number here, infinite there."""

    def _evaluate(self, X, out, *args, **kwargs):
        super()._evaluate(X, out)
        out["F"] = np.where(X[:, 0] < -0.2, np.nan, np.where(X[:, 1] > 700.0, np.inf, out["F"]))


class Fenced(Bowl):
    """Inequalities, and an equation that pymoo tolerates a small error of."""

    def __init__(self):
        super().__init__(n_ieq_constr=3, n_eq_constr=1)

    def _evaluate(self, X, out, *args, **kwargs):
        super()._evaluate(X, out)
        out["G"] = np.stack([0.1 - X[:, 0], X[:, 1] - 500.0, X[:, 0] - X[:, 1]], axis=1)
        out["H"] = (0.5 * X[:, 0] - 0.1)[:, None]


class Telling(Bowl):
    """Says more than it must, and mends what it is asked about."""

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
    """Wants to know who asks."""

    def __init__(self):
        super().__init__(requires_kwargs=True)

    def _evaluate(self, X, out, *args, algorithm, **kwargs):
        super()._evaluate(X, out)
        out["F"] = out["F"] / algorithm.n_gen


ALL = [
    SPHERE,
    Bowl(),
    Sunk(),
    Holed(),
    Fenced(),
    Telling(),
    OneByOne(),
    Curious(),
    Bowl(replace_nan_values_by=7.0),
    get_problem("rastrigin", n_var=2),
    get_problem("g1"),
]
