"""SciPy's differential evolution, restarted whenever it ends."""

from typing import Any, final

import numpy as np

from robolaser.arrays import Array
from robolaser.benchmark.evaluator import BudgetedEvaluator
from robolaser.benchmark.solvers.solver import Solver, within


@final
class ScipyEvolution(Solver):
    """`scipy.optimize.differential_evolution`, settings by SciPy's names; it evaluates whole populations at once."""

    name = "scipy-de"
    title = "SciPy's differential evolution"

    def __init__(
        self,
        *,
        popsize: int = 15,
        maxiter: int = 1000,
        tol: float = 0.01,
        recombination: float = 0.7,
        strategy: str = "best1bin",
        polish: bool = True,
    ) -> None:
        self._settings = {"popsize": popsize, "maxiter": maxiter, "tol": tol, "recombination": recombination,
                          "strategy": strategy, "polish": polish}  # fmt: skip

    def search(self, evaluator: BudgetedEvaluator, seed: int) -> None:
        """Search until the evaluator ends the run."""
        from scipy.optimize import Bounds, differential_evolution  # noqa: PLC0415 - half a second to import

        problem, rng = evaluator.problem, np.random.default_rng(seed)
        settings: dict[str, Any] = self._settings

        def costs(x: Array, /) -> Any:
            found = evaluator.cost(within(np.atleast_2d(x.T), problem))
            return found if x.ndim == 2 else found[0]

        while True:
            differential_evolution(
                costs,
                Bounds(problem.lower, problem.upper),
                vectorized=True,
                updating="deferred",
                seed=int(rng.integers(1, 2**31)),
                **settings,
            )
