"""The solvers of a benchmark, by name."""

from collections.abc import Callable, Mapping
from functools import partial

from robolaser.algorithms.algorithm_spec import Request
from robolaser.algorithms.registry import ALGORITHMS
from robolaser.algorithms.settings import check
from robolaser.benchmark.solvers.least_squares import LeastSquares
from robolaser.benchmark.solvers.pycma import Pycma
from robolaser.benchmark.solvers.pymoo_algorithm import PymooAlgorithm
from robolaser.benchmark.solvers.random_search import RandomSearch
from robolaser.benchmark.solvers.scipy_evolution import ScipyEvolution
from robolaser.benchmark.solvers.screening import Screening
from robolaser.benchmark.solvers.solver import Solver
from robolaser.benchmark.solvers.user_solver import own
from robolaser.errors import AlgorithmUnknown, RequestUnreadable

_OURS: Mapping[str, type[Screening | Pycma | LeastSquares | ScipyEvolution | RandomSearch]] = {
    kind.called: kind for kind in (Screening, Pycma, LeastSquares, ScipyEvolution, RandomSearch)
}

SOLVERS: Mapping[str, str] = {
    Screening.called: Screening.title,
    **{algorithm.name: algorithm.title for algorithm in ALGORITHMS.values()},
    **{name: kind.title for name, kind in _OURS.items()},
}
"""Titles by name."""
DEFAULT: tuple[str, ...] = tuple(SOLVERS)
"""Solvers that take part if none are named."""


def find(text: str) -> Solver:
    """Make the solver that a text names: `NAME` or `package.module:attribute`, and `:key=value` for each setting.

    Raises:
        AlgorithmUnknown: There is none of that name.
        RequestUnreadable, SettingUnknown, SettingSenseless, SettingsRefused: Its settings are not right.
        NotImportable, AttributeLacking, NotAnAlgorithm: It is not where it is said to be, or cannot search.
    """
    request = Request.of(text)
    if request.attribute is not None and request.name in SOLVERS:
        raise RequestUnreadable(text, f"'{request.attribute}' is no setting")
    if request.attribute is not None:
        return own(request)
    if request.name in ALGORITHMS:
        named = ALGORITHMS[request.name]
        if request.settings:
            named.made(request.settings)
        return PymooAlgorithm(text, named.title, partial(named.made, request.settings))
    if request.name not in _OURS:
        raise AlgorithmUnknown(request.name, SOLVERS)
    kind = _OURS[request.name]
    check(request.name, request.settings, kind.settings)
    make: Callable[..., Solver] = kind
    return make(text, **request.settings)
