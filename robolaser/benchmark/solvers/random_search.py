"""Random search: what every other solver has to beat."""

from typing import final

import numpy as np

from robolaser.benchmark.evaluator import BudgetedEvaluator
from robolaser.benchmark.problem import BenchmarkProblem
from robolaser.benchmark.solvers.solver import Solver

BATCH = 100


@final
class RandomSearch(Solver):
    """Uniform within the bounds."""

    name = "random"
    title = "uniformly random candidates: what every search has to beat"

    def refuses(self, problem: BenchmarkProblem) -> str | None:
        """It does not mind several objectives, nor variables of any kind."""
        return None

    def search(self, evaluator: BudgetedEvaluator, seed: int) -> None:
        """Search until the evaluator ends the run."""
        rng = np.random.default_rng(seed)
        while True:
            evaluator.evaluate(evaluator.problem.sample_uniform(rng, BATCH))
