"""The solvers of a benchmark, by name."""

from collections.abc import Callable, Mapping
from functools import partial

from robolaser.algorithms.algorithm_spec import AlgorithmSpec, malformed
from robolaser.algorithms.exchanged import make_exchanged, parted, stock_class
from robolaser.algorithms.registry import ALGORITHMS, algorithms, unknown_algorithm
from robolaser.algorithms.settings import check
from robolaser.algorithms.user_code import imported
from robolaser.benchmark.solvers.least_squares import ScipyLeastSquares
from robolaser.benchmark.solvers.pycma import Pycma
from robolaser.benchmark.solvers.pymoo_algorithm import PymooAlgorithm
from robolaser.benchmark.solvers.random_search import RandomSearch
from robolaser.benchmark.solvers.scipy_evolution import ScipyEvolution
from robolaser.benchmark.solvers.screening import Screening
from robolaser.benchmark.solvers.solver import Solver
from robolaser.benchmark.solvers.user_solver import user_solver

_OURS: Mapping[str, type[Screening | Pycma | ScipyLeastSquares | ScipyEvolution | RandomSearch]] = {
    kind.called: kind for kind in (Screening, Pycma, ScipyLeastSquares, ScipyEvolution, RandomSearch)
}

SOLVERS: Mapping[str, str] = {
    Screening.called: Screening.title,
    **{algorithm.name: algorithm.title for algorithm in ALGORITHMS.values()},
    **{name: kind.title for name, kind in _OURS.items()},
}
"""Titles of our solvers by name."""
DEFAULT: tuple[str, ...] = tuple(SOLVERS)
"""Solvers that take part if none are named."""


def solver_titles() -> Mapping[str, str]:
    """Titles of all solvers by name, those of installed packages last."""
    return {**SOLVERS} | {name: algorithm.title for name, algorithm in algorithms().items() if name not in SOLVERS}


def find(given: object) -> Solver:
    """Make the solver that a text names: `NAME` or `package.module:attribute`, and `:key=value` for each setting.

    A function, class or instance is what else would lie at an import path.

    Raises:
        UsageError: There is no such solver, it cannot search, or it cannot be made with these settings.
    """
    if not isinstance(given, str):
        return user_solver(AlgorithmSpec(getattr(given, "__name__", type(given).__name__), ""), given)
    text = given
    stock, parts = parted(text)
    spec = AlgorithmSpec.of(stock)
    if parts or (spec.attribute is None and spec.name not in solver_titles() and stock_class(spec.name)):
        title = solver_titles().get(spec.name) or f"pymoo's {spec.name}" if spec.attribute is None else stock
        with_ = f" with {' and '.join(f'{operator} as {slot}' for slot, operator in parts.items())}" if parts else ""
        return PymooAlgorithm(text, title + with_, make_exchanged(text))
    if spec.attribute is not None:
        if spec.name in solver_titles():
            raise malformed(text, f"'{spec.attribute}' is not a setting")
        return user_solver(spec, imported(spec))
    if spec.name in algorithms():
        algorithm = algorithms()[spec.name]
        if spec.settings:
            algorithm.make_with(spec.settings)
        return PymooAlgorithm(text, algorithm.title, partial(algorithm.make_with, spec.settings))
    if spec.name not in _OURS:
        raise unknown_algorithm(spec.name, solver_titles())
    kind = _OURS[spec.name]
    check(spec.name, spec.settings, kind.settings)
    make: Callable[..., Solver] = kind
    return make(text, **spec.settings)
