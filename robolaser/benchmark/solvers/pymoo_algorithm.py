"""Any pymoo algorithm, restarted whenever it ends."""

from collections.abc import Callable
from copy import copy
from typing import Any, final

import numpy as np

from robolaser.arrays import Array
from robolaser.benchmark.evaluator import BudgetedEvaluator
from robolaser.benchmark.problem import BenchmarkProblem
from robolaser.benchmark.solvers.solver import ONE_OBJECTIVE, Solver, within
from robolaser.errors import AlgorithmError

IDLE_ROUNDS = 1000
"""Iterations without a candidate after which an algorithm is taken to loop for ever."""
COLLAPSED = 1e-9
"""Share of the distance between the bounds within which candidates are the same: J changes with its square."""


@final
class PymooAlgorithm(Solver):
    """A pymoo algorithm; when it ends or its population has collapsed, it restarts with another seed.

    The remaining budget is its only termination, so k/T of the operators is the share of the budget that is used up.
    """

    def __init__(self, name: str, title: str, make: Callable[[], Any]) -> None:
        self.name, self.title, self._make = name, title, make

    def refuses(self, problem: BenchmarkProblem) -> str | None:
        """Those of pymoo's algorithms that know one objective only say so, and who samples no first candidates."""
        if len(problem.starts) and not hasattr(self._make(), "initialization"):
            return "it cannot begin with given candidates"
        if problem.front is None:
            return None
        single = any(kind.__module__.startswith("pymoo.algorithms.soo.") for kind in type(self._make()).__mro__)
        return ONE_OBJECTIVE if single else None

    def search(self, evaluator: BudgetedEvaluator, seed: int) -> None:
        """Search until the evaluator ends the run; one that goes on without a candidate raises AlgorithmError."""
        from robolaser.algorithms.seeding import seeded  # noqa: PLC0415 - pymoo takes a second to import
        from robolaser.problems.bounded import Bounded  # noqa: PLC0415

        problem, rng, idle = evaluator.problem, np.random.default_rng(seed), 0
        n_obj, starts = 1 if problem.front is None else len(problem.front.ideal), problem.starts
        with seeded(seed):
            while idle < IDLE_ROUNDS:
                costs = _Costs(evaluator)
                algorithm, bounded = self._make(), Bounded(costs, problem.lower, problem.upper, n_obj=n_obj)
                if len(starts):  # only the first time: what collapsed there would collapse again
                    algorithm.initialization.sampling = _starting(starts, algorithm.initialization.sampling)
                    starts = starts[:0]
                algorithm.setup(bounded, termination=("n_eval", evaluator.left), seed=seed, verbose=False)
                idle += 1  # it may end before it begins
                while algorithm.has_next() and not costs.collapsed and idle < IDLE_ROUNDS:
                    before = evaluator.evaluations
                    algorithm.next()
                    idle = idle + 1 if evaluator.evaluations == before else 0
                seed = int(rng.integers(1, 2**31))
        raise idle_error(idle)


def idle_error(iterations: int) -> AlgorithmError:
    """A search that evaluates nothing would never use up its budget."""
    return AlgorithmError(f"It made {iterations} iterations without evaluating a candidate.")


def _starting(starts: Array, sampling: Any) -> Any:
    """A sampling whose first candidates are given, (k, d); fixed candidates in place of a sampling stay."""
    if not hasattr(sampling, "_do"):
        return sampling

    def do(*arguments: Any, **settings: Any) -> Array:
        x: Array = sampling._do(*arguments, **settings)
        x[: len(starts)] = starts[: len(x)]
        return x

    started = copy(sampling)
    started._do = do
    return started


@final
class _Costs:
    """Objectives of candidates; notices when candidates no longer differ."""

    def __init__(self, evaluator: BudgetedEvaluator) -> None:
        self._evaluator = evaluator
        problem = evaluator.problem
        self._width = problem.upper - problem.lower
        self._limit = 20 + 2 * problem.dimension
        self._equal = 0
        self._last: Array = np.full(problem.dimension, np.nan)

    def __call__(self, x: Array) -> Array:
        if (np.abs(x - self._last) <= COLLAPSED * self._width).all():
            self._equal += len(x)
        else:
            self._equal, self._last = 0, x[-1].copy()
        return self._evaluator.objectives(within(x, self._evaluator.problem))

    @property
    def collapsed(self) -> bool:
        """Whether the last candidates, more than a simplex has corners, were all equal."""
        return self._equal >= self._limit
