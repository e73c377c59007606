"""Any pymoo algorithm, restarted whenever it ends."""

from collections.abc import Callable
from typing import Any, final

import numpy as np

from robolaser.benchmark.evaluator import BudgetedEvaluator
from robolaser.benchmark.problem import BenchmarkProblem
from robolaser.benchmark.solvers.solver import ONE_OBJECTIVE, REAL, Solver, within
from robolaser.errors import AlgorithmError

IDLE_ROUNDS = 1000
"""Iterations without a candidate after which an algorithm is taken to loop for ever."""
COLLAPSED = 1e-9
"""Share of the distance between the bounds within which candidates are the same: J changes with its square."""
FOR_REALS = ("FloatRandomSampling", "LatinHypercubeSampling", "LHS")


@final
class PymooAlgorithm(Solver):
    """A pymoo algorithm; when it ends or its population has collapsed, it restarts with another seed.

    The remaining budget is its only termination, so k/T of the operators is the share of the budget that is used up.
    It sees objectives and constraints as they are.
    """

    def __init__(self, name: str, title: str, make: Callable[[int], Any]) -> None:
        self.name, self.title, self._make = name, title, make
        made = make(2)
        self.knows_budget = _has_a_schedule(made)

    def refuses(self, problem: BenchmarkProblem) -> str | None:
        """Those that know one objective only say so, and those that only make real numbers."""
        made = self._make(problem.n_obj)
        kinds = {kind.__name__: kind.__module__ for kind in type(made).__mro__}
        if problem.n_obj > 1 and any(home.startswith("pymoo.algorithms.soo.") for home in kinds.values()):
            return ONE_OBJECTIVE
        if problem.n_obj > 1 and "RCGA" in kinds:
            return ONE_OBJECTIVE
        if problem.mixed or "MixedVariableGA" in kinds:
            return None if problem.mixed and "MixedVariableGA" in kinds else REAL
        sampling = getattr(getattr(made, "initialization", None), "sampling", None)
        return REAL if problem.discrete and (sampling is None or type(sampling).__name__ in FOR_REALS) else None

    def search(self, evaluator: BudgetedEvaluator, seed: int) -> None:
        """Search until the evaluator ends the run; one that goes on without a candidate raises AlgorithmError."""
        from robolaser.algorithms.seeding import seeded  # noqa: PLC0415 - pymoo takes a second to import

        problem, rng, idle = evaluator.problem, np.random.default_rng(seed), 0
        with seeded(seed):
            while idle < IDLE_ROUNDS:
                counted = _counted(evaluator)
                algorithm = self._make(problem.n_obj)
                algorithm.setup(counted, termination=("n_eval", evaluator.left), seed=seed, verbose=False)
                idle += 1  # it may end before it begins
                while algorithm.has_next() and not counted.collapsed and idle < IDLE_ROUNDS:
                    before = evaluator.evaluations
                    algorithm.next()
                    idle = idle + 1 if evaluator.evaluations == before else 0
                seed = int(rng.integers(1, 2**31))
        raise idle_error(idle)


def idle_error(iterations: int) -> AlgorithmError:
    """A search that evaluates nothing would never use up its budget."""
    return AlgorithmError(f"It made {iterations} iterations without evaluating a candidate.")


def _has_a_schedule(algorithm: Any) -> bool:
    """Does the budget change how it searches, by its mutation's k/T or, in RVEA, by its adaptation?"""
    mutation = getattr(getattr(algorithm, "mating", None), "mutation", None) or getattr(algorithm, "mutation", None)
    scheduled = getattr(mutation, "progress_of", None) is not None and getattr(mutation, "progress", None) is None
    return scheduled or any(kind.__name__ == "RVEA" for kind in type(algorithm).__mro__)


def _counted(evaluator: BudgetedEvaluator) -> Any:
    """The problem as pymoo sees it: same variables, objectives and constraints, but every evaluation counts."""
    from pymoo.core.problem import Problem  # noqa: PLC0415 - pymoo takes a second to import

    problem, question = evaluator.problem, evaluator.problem.question

    class Counted(Problem):  # type: ignore[misc]
        """Notices when candidates no longer differ."""

        def __init__(self) -> None:
            shape = {"n_var": problem.dimension, "xl": question.xl, "xu": question.xu}
            if problem.mixed:
                shape = {"vars": question.vars}
            super().__init__(
                n_obj=problem.n_obj,
                n_ieq_constr=question.n_ieq_constr,
                n_eq_constr=question.n_eq_constr,
                vtype=question.vtype,
                **shape,
            )
            self._equal, self._last = 0, np.full(problem.dimension, np.nan)

        @property
        def collapsed(self) -> bool:
            """Whether the last candidates, more than a simplex has corners, were all equal."""
            return self._equal >= 20 + 2 * problem.dimension

        def _evaluate(self, X: Any, out: dict[str, Any], *args: Any, **kwargs: Any) -> None:
            if not problem.mixed:
                X = np.asarray(X, np.float64)
                if (np.abs(X - self._last) <= COLLAPSED * (problem.upper - problem.lower)).all():
                    self._equal += len(X)
                else:
                    self._equal, self._last = 0, X[-1].copy()
                X = within(X, problem)
            out.update({name: value for name, value in evaluator.evaluate(X).items() if value.shape[1]})

    return Counted()
