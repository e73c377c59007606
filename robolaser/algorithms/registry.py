"""The algorithms that have a name."""

import inspect
from collections.abc import Callable, Iterable, Mapping
from dataclasses import dataclass
from functools import cache
from importlib.metadata import entry_points
from itertools import product
from typing import Any, final

from robolaser.algorithms.algorithm_spec import AlgorithmSpec
from robolaser.algorithms.lazy import lazy_factory
from robolaser.algorithms.operator_choices import operator_settings, with_operators
from robolaser.algorithms.settings import Setting, Value, check, not_made, number, share, switch, whole, word
from robolaser.algorithms.user_code import made_with, user_algorithm
from robolaser.errors import AlgorithmError, UsageError, near
from robolaser.plugins import announced

POPULATION = 100


@final
@dataclass(frozen=True)
class NamedAlgorithm:
    """An algorithm with a name.

    Attributes:
        name: The name.
        title: A description for a person.
        make: Makes it with settings.
        settings: Settings that it has; None if those of the class count.
        has_operators: Whether its operators can be chosen.
    """

    name: str
    title: str
    make: Callable[..., Any]
    settings: tuple[Setting, ...] | None = ()
    has_operators: bool = False

    def make_with(self, given: Mapping[str, Value]) -> Any:
        """Make it with settings.

        Raises:
            UsageError: It has no such setting, a value makes no sense, or one does not go with another.
        """
        if self.settings is None:
            return made_with(AlgorithmSpec(self.name, self.name, settings=given), self.make)
        check(self.name, given, [*self.settings, *(operator_settings(given) if self.has_operators else ())])
        try:
            return self.make(**(with_operators(given) if self.has_operators else given))
        except Exception as error:
            raise not_made(self.name, error) from error


def _ga(**settings: Any) -> Any:
    """pymoo's, with as many offspring as individuals are replaced: with elites fewer than parents, as in `RCGA`."""
    from pymoo.algorithms.soo.nonconvex.ga import GA  # noqa: PLC0415 - pymoo takes a second to import

    settings = {"pop_size": POPULATION, **settings}
    elites = getattr(settings.get("survival"), "n_elites", 0)
    if elites >= settings["pop_size"]:
        raise AlgorithmError(f"GA: survival.n_elites is {elites!r}, expected fewer than pop_size.")
    return GA(**{"n_offsprings": settings["pop_size"] - elites, **settings})


def _stock(module: str, kind: str, **usual: Any) -> Callable[..., Any]:
    return lazy_factory(f"pymoo.algorithms.soo.nonconvex.{module}", kind, **usual)


_POP_SIZE, _OFFSPRING, _SAMPLES = whole("pop_size", 2), whole("n_offsprings"), whole("n_sample_points")
_ES = (_OFFSPRING, _POP_SIZE, share("rule"), number("phi"), number("gamma"))
_VARIANTS = [
    "/".join(("DE", *parts))
    for parts in product(("rand", "best", "target-to-best"), "12", ("bin", "exp", "hypercube", "line"))
]

_ALL = (
    NamedAlgorithm(
        "rcga",
        "Lee, Yoon and Kang's real-coded genetic algorithm, 2004",
        lazy_factory("robolaser.algorithms.rcga", "RCGA", pop_size=POPULATION),
        (
            _POP_SIZE,
            whole("n_elites", 0),
            share("prob_crossover"),
            share("prob_var"),
            number("b"),
            word("form", ("linear", "power")),
        ),
    ),
    NamedAlgorithm(
        "ga",
        "pymoo's genetic algorithm",
        _ga,
        (_POP_SIZE, _OFFSPRING, switch("eliminate_duplicates")),
        has_operators=True,
    ),
    NamedAlgorithm(
        "de",
        "pymoo's differential evolution",
        _stock("de", "DE", pop_size=POPULATION),
        (_POP_SIZE, _OFFSPRING, word("variant", _VARIANTS), number("F"), share("CR"), switch("jitter")),
    ),
    NamedAlgorithm(
        "pso",
        "pymoo's particle swarm",
        _stock("pso", "PSO", pop_size=POPULATION),
        (
            _POP_SIZE,
            number("w"),
            number("c1"),
            number("c2"),
            switch("adaptive"),
            word("initial_velocity", ("random", "zero")),
            number("max_velocity_rate"),
            switch("pertube_best"),
        ),
    ),
    NamedAlgorithm("es", "pymoo's evolution strategy", _stock("es", "ES"), _ES),
    NamedAlgorithm(
        "isres", "pymoo's improved stochastic ranking strategy", _stock("isres", "ISRES"), (*_ES, share("alpha"))
    ),
    NamedAlgorithm(
        "g3pcx",
        "pymoo's parent-centric steady-state genetic algorithm",
        _stock("g3pcx", "G3PCX"),
        (_POP_SIZE, _OFFSPRING, whole("n_parents", 3), whole("family_size")),
    ),
    NamedAlgorithm(
        "cmaes",
        "pymoo's covariance matrix adaptation",
        _stock("cmaes", "CMAES"),
        (
            number("sigma"),
            whole("pop_size", 3),
            whole("restarts", 0),
            switch("bipop"),
            number("tolfun"),
            number("tolx"),
            _SAMPLES,
        ),
    ),
    NamedAlgorithm("nelder-mead", "pymoo's simplex", _stock("nelder", "NelderMead"), (_SAMPLES,)),
    NamedAlgorithm(
        "pattern-search",
        "pymoo's pattern search",
        _stock("pattern", "PatternSearch"),
        (share("init_delta"), share("init_rho"), number("step_size"), _SAMPLES),
    ),
)

ALGORITHMS: Mapping[str, NamedAlgorithm] = {algorithm.name: algorithm for algorithm in _ALL}
"""Our global searches by name."""

SCREENING = "screening"
"""The default: random candidates of the whole box, the best of them refined until enough end at one optimum."""
POLISH_ONLY = "gauss-newton"
"""Instead of a global search: straight from the nominal values and closed forms to the polish."""


GROUP = "robolaser.algorithms"  # entry points under which installed packages announce pymoo algorithms


@cache
def algorithms() -> Mapping[str, NamedAlgorithm]:
    """Our algorithms and those that installed packages announce, by name.

    Raises:
        PluginError: What a package announces cannot be used.
    """
    if not entry_points(group=GROUP):
        return ALGORITHMS
    from pymoo.core.algorithm import Algorithm  # noqa: PLC0415 - pymoo takes a second to import

    kinds = announced(GROUP, Algorithm, taken=[SCREENING, *ALGORITHMS, POLISH_ONLY], name="")
    titles = {name: (inspect.getdoc(kind) or name).splitlines()[0].rstrip(".") for name, kind in kinds.items()}
    return {**ALGORITHMS, **{name: NamedAlgorithm(name, titles[name], kind, None) for name, kind in kinds.items()}}


def algorithm_named(text: str) -> Any:
    """Make the pymoo algorithm that a text names: `NAME` or `package.module:attribute`, with `:key=value` after it.

    Raises:
        UsageError: There is no such algorithm, or it cannot be made with these settings.
    """
    spec = AlgorithmSpec.of(text)
    if spec.attribute is not None:
        return user_algorithm(spec)
    if spec.name in (SCREENING, POLISH_ONLY):
        check(spec.name, spec.settings, ())
    if spec.name not in algorithms():
        raise unknown_algorithm(spec.name, [SCREENING, *algorithms(), POLISH_ONLY])
    return algorithms()[spec.name].make_with(spec.settings)


def unknown_algorithm(name: str, known: Iterable[str]) -> UsageError:
    """No algorithm has that name."""
    return UsageError(f"No algorithm '{name}'.{near(name, known)} One of your own is package.module:attribute.")
