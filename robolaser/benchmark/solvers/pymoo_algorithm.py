"""Any pymoo algorithm, restarted whenever it ends."""

from collections.abc import Callable
from functools import partial
from typing import Any

import numpy as np

from robolaser.benchmark.evaluator import BudgetedEvaluator
from robolaser.benchmark.problem import BenchmarkProblem
from robolaser.benchmark.solvers.solver import ONE_OBJECTIVE, REAL, Search, Solver, within
from robolaser.errors import AlgorithmError, UsageError

IDLE_ROUNDS = 1000  # iterations without a candidate that count as an endless loop
COLLAPSED = 1e-9  # of the distance between the bounds: candidates as near are the same; J changes with its square
FOR_REALS = ("FloatRandomSampling", "LatinHypercubeSampling", "LHS")

Maker = Callable[[int], Any]  # makes an algorithm, given the number of objectives


def pymoo_solver(name: str, title: str, make: Maker) -> Solver:
    """A pymoo algorithm as a solver, which restarts it with another seed when it ends or its population has collapsed.

    The remaining budget is its only termination, so k/T of the operators is the share of the budget that is used up.
    It sees objectives and constraints as they are.
    """
    search = partial(restarted, partial(_search, make))
    return Solver(name, title, search, partial(_refuses, make), knows_budget=_has_a_schedule(make(2)))


def restarted(search: Search, evaluator: BudgetedEvaluator, seed: int) -> None:
    """Search with global generators seeded, and again with another seed whenever the search returns.

    Raises:
        AlgorithmError: It returns repeatedly without a candidate: it would never use up its budget.
    """
    from robolaser.algorithms.seeding import seeded  # noqa: PLC0415 - pymoo takes a second to import

    rng, idle = np.random.default_rng(seed), 0
    with seeded(seed):
        while idle < IDLE_ROUNDS:
            before = evaluator.evaluations
            search(evaluator, seed)
            if not evaluator.left:  # it caught the end of the budget
                return
            idle = idle + 1 if evaluator.evaluations == before else 0
            seed = int(rng.integers(1, 2**31))
    raise AlgorithmError(f"It was started {idle} times without evaluating a candidate.")


def _search(make: Maker, evaluator: BudgetedEvaluator, seed: int) -> None:
    counted, algorithm, idle = _counted(evaluator), make(evaluator.problem.n_obj), 0
    algorithm.setup(counted, termination=("n_eval", evaluator.left), seed=seed, verbose=False)
    while algorithm.has_next() and not counted.collapsed:
        before = evaluator.evaluations
        algorithm.next()
        idle = idle + 1 if evaluator.evaluations == before else 0
        if idle == IDLE_ROUNDS:
            raise AlgorithmError(f"It made {idle} iterations without evaluating a candidate.")


def _refuses(make: Maker, problem: BenchmarkProblem) -> str | None:
    """Reasons of algorithms for one objective only, for several only, and for real numbers only."""
    try:
        made = make(problem.n_obj)
    except UsageError as error:
        return str(error)
    kinds = {kind.__name__: kind.__module__ for kind in type(made).__mro__}
    single = "RCGA" in kinds or any(home.startswith("pymoo.algorithms.soo.") for home in kinds.values())
    if problem.n_obj > 1 and single:
        return ONE_OBJECTIVE
    if problem.mixed or "MixedVariableGA" in kinds:
        return None if problem.mixed and "MixedVariableGA" in kinds else REAL
    sampling = getattr(getattr(made, "initialization", None), "sampling", None)
    return REAL if problem.discrete and (sampling is None or type(sampling).__name__ in FOR_REALS) else None


def _has_a_schedule(algorithm: Any) -> bool:
    """Whether its search depends on the budget, by its mutation's k/T or, in RVEA, by its adaptation."""
    mutation = getattr(getattr(algorithm, "mating", None), "mutation", None) or getattr(algorithm, "mutation", None)
    scheduled = getattr(mutation, "progress_of", None) is not None and getattr(mutation, "progress", None) is None
    return scheduled or any(kind.__name__ == "RVEA" for kind in type(algorithm).__mro__)


def _counted(evaluator: BudgetedEvaluator) -> Any:
    """The problem for pymoo: same variables, objectives and constraints, but every evaluation counts."""
    from pymoo.core.problem import Problem  # noqa: PLC0415 - pymoo takes a second to import

    problem, question = evaluator.problem, evaluator.problem.question

    class Counted(Problem):  # type: ignore[misc]
        """Detects when candidates no longer differ."""

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
            """Whether the last candidates, more than the corners of a simplex, were all equal."""
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
