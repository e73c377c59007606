"""The algorithms that can be asked for by name."""

from collections.abc import Callable, Mapping
from dataclasses import dataclass
from itertools import product
from typing import Any, final

from robolaser.algorithms.algorithm_spec import Request
from robolaser.algorithms.imported import algorithm_of, imported
from robolaser.algorithms.lazy import lazily
from robolaser.algorithms.operator_specs import made_parts, settings_of_parts
from robolaser.algorithms.settings import Setting, Value, check, number, share, switch, whole, word
from robolaser.errors import AlgorithmUnknown, OperatorSetting, SettingsRefused

POPULATION = 100


@final
@dataclass(frozen=True)
class Named:
    """An algorithm by its name.

    Attributes:
        name: As users call it.
        title: What it is.
        make: Makes it with settings.
        settings: That it understands.
        in_parts: Whether operators can be put into it.
    """

    name: str
    title: str
    make: Callable[..., Any]
    settings: tuple[Setting, ...] = ()
    in_parts: bool = False

    def made(self, given: Mapping[str, Value]) -> Any:
        """Make it with settings.

        Raises:
            SettingUnknown, SettingSenseless: It has no such setting, or the value has no meaning.
            SettingsRefused: One does not go with another.
        """
        check(self.name, given, [*self.settings, *(settings_of_parts(given) if self.in_parts else ())])
        try:
            return self.make(**(made_parts(given) if self.in_parts else given))
        except Exception as error:
            raise SettingsRefused(self.name, error) from error


def _ga(**settings: Any) -> Any:
    """pymoo's, with as many offspring as have to be born: with elites fewer than there are parents, as in `RCGA`."""
    from pymoo.algorithms.soo.nonconvex.ga import GA  # noqa: PLC0415 - pymoo takes a second to import

    settings = {"pop_size": POPULATION, **settings}
    elites = getattr(settings.get("survival"), "n_elites", 0)
    if elites >= settings["pop_size"]:
        raise OperatorSetting("GA", "survival.n_elites", elites, "fewer than pop_size")
    return GA(**{"n_offsprings": settings["pop_size"] - elites, **settings})


def _stock(module: str, kind: str, **usual: Any) -> Callable[..., Any]:
    return lazily(f"pymoo.algorithms.soo.nonconvex.{module}", kind, **usual)


_POP_SIZE, _OFFSPRING, _SAMPLES = whole("pop_size", 2), whole("n_offsprings"), whole("n_sample_points")
_ES = (_OFFSPRING, _POP_SIZE, share("rule"), number("phi"), number("gamma"))
_VARIANTS = [
    "/".join(("DE", *parts))
    for parts in product(("rand", "best", "target-to-best"), "12", ("bin", "exp", "hypercube", "line"))
]

_ALL = (
    Named(
        "rcga",
        "Lee, Yoon and Kang's real-coded genetic algorithm, 2004",
        lazily("robolaser.algorithms.rcga", "RCGA", pop_size=POPULATION),
        (
            _POP_SIZE,
            whole("n_elites", 0),
            share("prob_crossover"),
            share("prob_var"),
            number("b"),
            word("form", ("linear", "power")),
        ),
    ),
    Named(
        "ga",
        "pymoo's genetic algorithm",
        _ga,
        (_POP_SIZE, _OFFSPRING, switch("eliminate_duplicates")),
        in_parts=True,
    ),
    Named(
        "de",
        "pymoo's differential evolution",
        _stock("de", "DE", pop_size=POPULATION),
        (_POP_SIZE, _OFFSPRING, word("variant", _VARIANTS), number("F"), share("CR"), switch("jitter")),
    ),
    Named(
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
    Named("es", "pymoo's evolution strategy", _stock("es", "ES"), _ES),
    Named(
        "isres",
        "pymoo's improved stochastic ranking strategy",
        _stock("isres", "ISRES"),
        (*_ES, share("alpha")),
    ),
    Named(
        "g3pcx",
        "pymoo's parent-centric steady-state genetic algorithm",
        _stock("g3pcx", "G3PCX"),
        (_POP_SIZE, _OFFSPRING, whole("n_parents", 3), whole("family_size")),
    ),
    Named(
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
    Named("nelder-mead", "pymoo's simplex", _stock("nelder", "NelderMead"), (_SAMPLES,)),
    Named(
        "pattern-search",
        "pymoo's pattern search",
        _stock("pattern", "PatternSearch"),
        (share("init_delta"), share("init_rho"), number("step_size"), _SAMPLES),
    ),
)

ALGORITHMS: Mapping[str, Named] = {one.name: one for one in _ALL}
"""Global searches by name."""

SCREENING = "screening"
"""The default: random candidates of the closed-form reduction, the best of them sent downhill until they agree."""
POLISH_ONLY = "gauss-newton"
"""Instead of a global search: straight from the nominal values and closed forms to the polish."""


def algorithm_named(text: str) -> Any:
    """Make the pymoo algorithm that a text asks for: `NAME` or `package.module:attribute`, with `:key=value` after it.

    Raises:
        AlgorithmUnknown: There is none of that name.
        RequestUnreadable, SettingUnknown, SettingSenseless, SettingsRefused: Its settings are not right.
        NotImportable, AttributeLacking, NotAnAlgorithm: It is not where it is said to be.
    """
    request = Request.of(text)
    if request.attribute is not None:
        return algorithm_of(request, imported(request))
    if request.name in (SCREENING, POLISH_ONLY):
        check(request.name, request.settings, ())
    if request.name not in ALGORITHMS:
        raise AlgorithmUnknown(request.name, [SCREENING, *ALGORITHMS, POLISH_ONLY])
    return ALGORITHMS[request.name].made(request.settings)
