"""The solvers of a benchmark, by name."""

from collections.abc import Mapping, Sequence

from robolaser.algorithms.registry import ALGORITHMS, algorithms, maker_of, pymoos, unknown_algorithm
from robolaser.algorithms.spec import AlgorithmSpec
from robolaser.algorithms.user_code import made
from robolaser.benchmark.solvers.least_squares import ScipyLeastSquares
from robolaser.benchmark.solvers.pycma import Pycma
from robolaser.benchmark.solvers.pymoo_algorithm import PymooAlgorithm
from robolaser.benchmark.solvers.random_search import RandomSearch
from robolaser.benchmark.solvers.scipy_evolution import ScipyEvolution
from robolaser.benchmark.solvers.screening import Screening
from robolaser.benchmark.solvers.solver import Solver
from robolaser.benchmark.solvers.user_solver import user_solver
from robolaser.errors import UsageError

_OURS: Mapping[str, type[Screening | Pycma | ScipyLeastSquares | ScipyEvolution | RandomSearch]] = {
    kind.name: kind for kind in (Screening, Pycma, ScipyLeastSquares, ScipyEvolution, RandomSearch)
}
SOLVERS: Mapping[str, str] = {
    Screening.name: Screening.title,
    **{name: algorithm.title for name, algorithm in ALGORITHMS.items()},
    **{name: kind.title for name, kind in _OURS.items()},
}
"""Titles of our solvers by name."""
DEFAULT: tuple[str, ...] = tuple(SOLVERS)
"""Solvers that take part if none are named."""


def solver_titles() -> Mapping[str, str]:
    """Titles of all solvers by name, those of installed packages last."""
    return {**SOLVERS} | {name: algorithm.title for name, algorithm in algorithms().items() if name not in SOLVERS}


def solvers_of(given: Sequence[object] | Mapping[str, object]) -> dict[str, Solver]:
    """The solvers that are meant, by name; who comes twice takes part once.

    Raises:
        UsageError: There is no such solver, it cannot search, or two have one name.
    """
    pairs = list(given.items()) if isinstance(given, Mapping) else [("", one) for one in given]
    found: dict[str, tuple[object, Solver]] = {}
    for name, one in pairs:
        solver = find(one, str(name))
        if solver.name in found and found[solver.name][0] is not one and found[solver.name][0] != one:
            raise UsageError(
                f"Two algorithms are called '{solver.name}', and results are stored by name. Name them:"
                ' compare(…, {"small": GA(pop_size=20), "large": GA(pop_size=50)}).'
            )
        found.setdefault(solver.name, (one, solver))
    return {name: solver for name, (_, solver) in found.items()}


def find(given: object, name: str = "") -> Solver:
    """Make the solver that a text specifies, or of a function, class or instance, which may be given a name.

    Raises:
        UsageError: There is no such solver, it cannot search, or it cannot be made with these settings.
    """
    if not isinstance(given, str):
        return user_solver(given, name)
    spec = AlgorithmSpec.of(given)
    if spec.attribute is not None:
        if spec.name in solver_titles():
            raise UsageError(f"'{given}' cannot be read: '{spec.attribute}' is not a setting.")
        return user_solver(given, name)
    if spec.name in _OURS:
        if spec.operators:
            raise UsageError(f"{given}: the operators of {spec.name} cannot be exchanged.")
        solver: Solver = made(given, _OURS[spec.name], spec.settings)
        solver.name = name or given
        return solver
    if spec.name not in algorithms() and pymoos("algorithms", spec.name) is None:
        raise unknown_algorithm(spec.name, solver_titles())
    title = solver_titles().get(spec.name) or f"pymoo's {spec.name}"
    parts = [f"{one.text} as {slot}" for slot, one in spec.operators.items()]
    return PymooAlgorithm(name or given, f"{title} with {' and '.join(parts)}" if parts else title, maker_of(spec))
