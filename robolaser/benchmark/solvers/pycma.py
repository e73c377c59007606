"""CMA-ES by its authors, with their restarts."""

import warnings
from typing import final

import numpy as np

from robolaser.arrays import Array
from robolaser.benchmark.evaluator import BudgetedEvaluator
from robolaser.benchmark.solvers.solver import Solver, within

SILENT = -9
"""pycma's setting for no output, neither on the terminal nor in files."""


@final
class Pycma(Solver):
    """Hansen's pycma with restarts that alternate large and small populations (BIPOP, Hansen 2009), in the unit box.

    Args:
        sigma: Initial step size in the unit box; 0.3 is the authors' advice.
        bipop: Whether restarts alternate small and large populations; if not, each is larger than the last.
        restarts: Restarts after which the search begins anew.
        tolfun: Restart when costs differ by less, in the cost's unit.
    """

    name = "pycma"
    title = "pycma: covariance matrix adaptation with BIPOP restarts"

    def __init__(self, *, sigma: float = 0.3, bipop: bool = True, restarts: int = 9, tolfun: float = 1e-11) -> None:
        self._sigma, self._bipop, self._restarts, self._tolfun = sigma, bipop, restarts, tolfun

    def search(self, evaluator: BudgetedEvaluator, seed: int) -> None:
        """Search until the evaluator ends the run."""
        import cma  # noqa: PLC0415 - half a second to import

        from robolaser.algorithms.seeding import seeded  # noqa: PLC0415

        problem, rng = evaluator.problem, np.random.default_rng(seed)
        width = problem.upper - problem.lower

        def costs(y: list[Array]) -> list[float]:
            found: list[float] = evaluator.cost(within(problem.lower + np.array(y) * width, problem)).tolist()
            return found

        with seeded(seed):
            warnings.simplefilter("ignore")
            while True:
                cma.fmin2(
                    None,
                    lambda: rng.uniform(size=problem.dimension),
                    self._sigma,
                    {
                        "bounds": [0, 1],
                        "seed": int(rng.integers(1, 2**31)),
                        "verbose": SILENT,
                        "tolfun": self._tolfun,
                    },
                    restarts=self._restarts,
                    bipop=self._bipop,
                    parallel_objective=costs,
                )
