"""The algorithms that can be asked for by name."""

from collections.abc import Callable, Mapping
from dataclasses import dataclass
from typing import Any, final

from robolaser.errors import AlgorithmUnknown

POPULATION = 100


@final
@dataclass(frozen=True)
class Named:
    """An algorithm by its name: what it is, and how to make it."""

    name: str
    title: str
    make: Callable[[], Any]


def _rcga() -> Any:
    from robolaser.algorithms.rcga import RCGA  # noqa: PLC0415 - pymoo takes a second to import

    return RCGA(pop_size=POPULATION)


def _stock(module: str, kind: str, **settings: Any) -> Callable[[], Any]:
    def make() -> Any:
        import importlib  # noqa: PLC0415

        return getattr(importlib.import_module(f"pymoo.algorithms.soo.nonconvex.{module}"), kind)(**settings)

    return make


_ALL = (
    Named("rcga", "Lee, Yoon and Kang's real-coded genetic algorithm, 2004", _rcga),
    Named("ga", "pymoo's genetic algorithm, its defaults", _stock("ga", "GA", pop_size=POPULATION)),
    Named("de", "pymoo's differential evolution, its defaults", _stock("de", "DE", pop_size=POPULATION)),
    Named("pso", "pymoo's particle swarm, its defaults", _stock("pso", "PSO", pop_size=POPULATION)),
    Named("es", "pymoo's evolution strategy, its defaults", _stock("es", "ES")),
    Named("isres", "pymoo's improved stochastic ranking strategy, its defaults", _stock("isres", "ISRES")),
    Named("cmaes", "pymoo's covariance matrix adaptation, its defaults", _stock("cmaes", "CMAES")),
    Named("nelder-mead", "pymoo's simplex, its defaults", _stock("nelder", "NelderMead")),
    Named("pattern-search", "pymoo's pattern search, its defaults", _stock("pattern", "PatternSearch")),
)

ALGORITHMS: Mapping[str, Named] = {one.name: one for one in _ALL}
"""Global searches by name."""

SCREENING = "screening"
"""The default: random candidates of the closed-form reduction, the best of them sent downhill until they agree."""
POLISH_ONLY = "gauss-newton"
"""Instead of a global search: straight from the nominal values and closed forms to the polish."""


def algorithm_named(name: str) -> Any:
    """Make the algorithm of that name.

    Raises:
        AlgorithmUnknown: There is none.
    """
    if name not in ALGORITHMS:
        raise AlgorithmUnknown(name, [SCREENING, *ALGORITHMS, POLISH_ONLY])
    return ALGORITHMS[name].make()
