"""Random search: what every other solver has to beat."""

from typing import ClassVar, final

import numpy as np

from robolaser.algorithms.settings import Setting
from robolaser.benchmark.evaluator import BudgetedEvaluator
from robolaser.benchmark.problem import BenchmarkProblem
from robolaser.benchmark.solvers.solver import Solver

BATCH = 100


@final
class RandomSearch(Solver):
    """Uniform within the bounds."""

    called: ClassVar[str] = "random"
    settings: ClassVar[tuple[Setting, ...]] = ()
    title = "uniformly random candidates: what every search has to beat"

    def __init__(self, name: str = called) -> None:
        self.name = name

    def refuses(self, problem: BenchmarkProblem) -> str | None:
        """It does not mind several objectives."""
        return None

    def search(self, evaluator: BudgetedEvaluator, seed: int) -> None:
        """Search until the evaluator ends the run."""
        rng = np.random.default_rng(seed)
        if len(evaluator.problem.starts):
            evaluator.objectives(evaluator.problem.starts)
        while True:
            evaluator.objectives(evaluator.problem.sample_uniform(rng, BATCH))
