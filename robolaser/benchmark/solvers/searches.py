"""Searches besides pymoo's algorithms: SciPy's, pycma, random candidates, and `calibrate`'s own.

Each is a function of an evaluator and a seed, as a user's search, with the settings of its library.
"""

import warnings
from collections.abc import Mapping
from typing import Any

import numpy as np

from robolaser.algorithms.registry import SCREENING
from robolaser.arrays import Array
from robolaser.benchmark.evaluator import BudgetedEvaluator
from robolaser.benchmark.problem import BenchmarkProblem
from robolaser.benchmark.solvers.solver import Solver, one_objective_of_reals, within

SILENT = -9  # pycma's setting for no output, neither on the terminal nor in files
SIGMA, RESTARTS = 0.3, 9  # its initial step in the unit box, as its authors advise; restarts before a new start
BATCH = 100  # random candidates that are evaluated together
TOL = 1e-12  # of least squares: SciPy's default, 1e-8, stops in a flat valley before the optimum


def random_search(evaluator: BudgetedEvaluator, seed: int) -> None:
    """Evaluate candidates that are uniform within the bounds."""
    rng = np.random.default_rng(seed)
    while True:
        evaluator.evaluate(evaluator.problem.sample_uniform(rng, BATCH))


def scipy_evolution(evaluator: BudgetedEvaluator, seed: int) -> None:
    """Run `scipy.optimize.differential_evolution`, whole populations at once, and restart it when it ends."""
    from scipy.optimize import Bounds, differential_evolution  # noqa: PLC0415 - half a second to import

    problem, rng = evaluator.problem, np.random.default_rng(seed)
    box = Bounds(problem.lower, problem.upper)

    def costs(x: Array, /) -> Any:
        found = evaluator.cost(within(np.atleast_2d(x.T), problem))
        return found if x.ndim == 2 else found[0]

    while True:
        differential_evolution(costs, box, vectorized=True, updating="deferred", seed=int(rng.integers(1, 2**31)))


def pycma(evaluator: BudgetedEvaluator, seed: int) -> None:
    """Run Hansen's pycma in the unit box, with restarts that alternate large and small populations (BIPOP, 2009)."""
    import cma  # noqa: PLC0415 - half a second to import

    from robolaser.algorithms.seeding import seeded  # noqa: PLC0415 - pymoo takes a second to import

    problem, rng = evaluator.problem, np.random.default_rng(seed)
    width = problem.upper - problem.lower

    def start() -> Array:
        return rng.uniform(size=problem.dimension)

    def costs(y: list[Array]) -> Any:
        return evaluator.cost(within(problem.lower + np.array(y) * width, problem)).tolist()

    with seeded(seed):
        warnings.simplefilter("ignore")
        while True:
            options = {"bounds": [0, 1], "seed": int(rng.integers(1, 2**31)), "verbose": SILENT}
            cma.fmin2(None, start, SIGMA, options, restarts=RESTARTS, bipop=True, parallel_objective=costs)


def least_squares(evaluator: BudgetedEvaluator, seed: int) -> None:
    """Run `scipy.optimize.least_squares` within the bounds, with its differences, from one random start after another.

    More exact derivatives would not help: unsuccessful descents then take five times as many candidates.
    """
    from scipy import optimize  # noqa: PLC0415 - half a second to import

    problem, rng = evaluator.problem, np.random.default_rng(seed)
    free = problem.upper > problem.lower
    bounds = problem.lower[free], problem.upper[free]
    options: dict[str, Any] = {"bounds": bounds, "x_scale": bounds[1] - bounds[0]}
    options |= dict.fromkeys(("ftol", "xtol", "gtol"), TOL)
    while True:
        x, before = problem.sample_uniform(rng)[0], evaluator.evaluations

        def residuals(z: Array, x: Array = x) -> Any:
            x[free] = z
            return evaluator.residuals(x[None])[0]

        try:
            optimize.least_squares(residuals, x[free], **options)
        except (ValueError, np.linalg.LinAlgError):  # the start or a column of the Jacobian is at a pole
            if evaluator.evaluations == before:
                raise


def screening(evaluator: BudgetedEvaluator, seed: int) -> None:
    """Run `robolaser.estimation.multistart` until descents agree; each round is counted, with J of all rows.

    `calibrate` also starts a descent from the nominal values. Here it does not: no other solver has them.
    """
    from robolaser.estimation.multistart import multistart  # noqa: PLC0415 - test functions need no models

    model = evaluator.problem.model
    assert model is not None  # other problems are refused
    counted, whole = 0, evaluator.problem.dimension == len(model.parameters)

    def record(evaluations: int, cost: float, x: Array) -> None:
        nonlocal counted
        evaluator.record(evaluations - counted + 1, cost, x if whole else None)  # and one on all rows, for J
        counted = evaluations

    def after_round(_: float, evaluations: int, x: Array) -> None:
        record(evaluations, float(model.cost(x[None])[0]), x)

    found = multistart(model, seed=seed, progress=after_round)
    record(found.evaluations, found.cost, found.x)


def _calibrations_only(problem: BenchmarkProblem) -> str | None:
    return None if problem.model is not None else "it knows calibrations only, by their closed forms"


def _sums_of_squares_only(problem: BenchmarkProblem) -> str | None:
    return None if problem.residuals is not None else "it needs residuals, and the cost is not a sum of squares"


SEARCHES: Mapping[str, Solver] = {  # by name
    one.name: one
    for one in (
        Solver(
            SCREENING,
            "robolaser's default: the best of random candidates refined until enough end at one optimum",
            screening,
            _calibrations_only,
        ),
        Solver("pycma", "pycma: covariance matrix adaptation with BIPOP restarts", pycma, one_objective_of_reals),
        Solver("least-squares", "SciPy's least squares from random starts", least_squares, _sums_of_squares_only),
        Solver("scipy-de", "SciPy's differential evolution", scipy_evolution, one_objective_of_reals),
        Solver("random", "uniformly random candidates: what every search has to beat", random_search),
    )
}
