"""Our own default search, which `robolaser calibrate` uses unless another is named."""

from typing import final

from robolaser.algorithms.registry import SCREENING
from robolaser.arrays import Array
from robolaser.benchmark.evaluator import BudgetedEvaluator
from robolaser.benchmark.problem import BenchmarkProblem
from robolaser.benchmark.solvers.solver import Solver


@final
class Screening(Solver):
    """`robolaser.estimation.multistart`, which ends when descents agree; each round is counted, with J of all rows.

    `calibrate` also starts a descent from the nominal values. Here it must not: no other solver knows them.
    """

    name = SCREENING
    title = "robolaser's default: the best of random candidates refined until enough end at one optimum"

    def refuses(self, problem: BenchmarkProblem) -> str | None:
        """It only applies to calibrations."""
        return None if problem.model is not None else "it knows calibrations only, by their closed forms"

    def search(self, evaluator: BudgetedEvaluator, seed: int) -> None:
        """Search until descents agree."""
        from robolaser.estimation.multistart import SoFar, multistart  # noqa: PLC0415 - test functions need no models

        model = evaluator.problem.model
        if model is None:
            raise TypeError(f"{evaluator.problem.name} is not a calibration")
        counted, whole = 0, evaluator.problem.dimension == len(model.parameters)

        def record(evaluations: int, cost: float, x: Array) -> None:
            nonlocal counted
            evaluator.record(evaluations - counted + 1, cost, x if whole else None)  # and one on all rows, for J
            counted = evaluations

        def after_round(so_far: SoFar) -> None:
            record(so_far.evaluations, float(model.cost(so_far.x[None])[0]), so_far.x)

        found = multistart(model, seed=seed, progress=after_round)
        record(found.evaluations, found.cost, found.x)
