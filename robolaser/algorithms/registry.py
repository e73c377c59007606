"""Algorithms and operators by name: ours, pymoo's, those of installed packages, and others by import path."""

import inspect
import re
from collections.abc import Callable, Iterable, Mapping
from dataclasses import dataclass, field
from functools import cache, partial
from importlib import import_module
from importlib.metadata import entry_points
from importlib.resources import files
from pathlib import Path
from typing import Any, final

from robolaser.algorithms.spec import AlgorithmSpec, Value
from robolaser.algorithms.user_code import copies, imported, keywords, made, named, title_of
from robolaser.errors import AlgorithmError, UsageError, near
from robolaser.plugins import announced

SCREENING = "screening"
"""The default: random candidates within the bounds, the best of them refined until enough end at one optimum."""
POLISH_ONLY = "gauss-newton"  # no global search: straight from nominal values and closed forms to the polish
GROUP, OPERATOR_GROUP = "robolaser.algorithms", "robolaser.operators"
"""Entry points under which installed packages announce algorithms, and operators of a slot (`.crossover`)."""
EXPECTED = "a pymoo algorithm: its class, an instance, or a function that returns one"
DIRECTIONS = {2: 99, 3: 12, 4: 7, 5: 5}
"""Partitions of the Das-Dennis reference directions, about a hundred, by the number of objectives; of more: 3."""


@final
@dataclass(frozen=True)
class NamedAlgorithm:
    """A named algorithm: its description, and the path of its class, `module:class`."""

    title: str
    home: str
    usual: Mapping[str, Value] = field(default_factory=dict)  # settings other than the class's own defaults


_SOO = "pymoo.algorithms.soo.nonconvex"
_HUNDRED = {"pop_size": 100}
ALGORITHMS: Mapping[str, NamedAlgorithm] = {  # our names of global searches
    "rcga": NamedAlgorithm("Lee, Yoon and Kang's real-coded genetic algorithm, 2004", "robolaser.algorithms.rcga:RCGA"),
    "ga": NamedAlgorithm("pymoo's genetic algorithm", f"{_SOO}.ga:GA", _HUNDRED),
    "de": NamedAlgorithm("pymoo's differential evolution", f"{_SOO}.de:DE", _HUNDRED),
    "pso": NamedAlgorithm("pymoo's particle swarm", f"{_SOO}.pso:PSO", _HUNDRED),
    "es": NamedAlgorithm("pymoo's evolution strategy", f"{_SOO}.es:ES"),
    "isres": NamedAlgorithm("pymoo's improved stochastic ranking strategy", f"{_SOO}.isres:ISRES"),
    "g3pcx": NamedAlgorithm("pymoo's parent-centric steady-state genetic algorithm", f"{_SOO}.g3pcx:G3PCX"),
    "cmaes": NamedAlgorithm("pymoo's covariance matrix adaptation", f"{_SOO}.cmaes:CMAES"),
    "nelder-mead": NamedAlgorithm("pymoo's simplex", f"{_SOO}.nelder:NelderMead"),
    "pattern-search": NamedAlgorithm("pymoo's pattern search", f"{_SOO}.pattern:PatternSearch"),
}


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
    theirs = {n: NamedAlgorithm(title_of(k, n), f"{k.__module__}:{k.__qualname__}") for n, k in kinds.items()}
    return {**ALGORITHMS, **theirs}


@cache
def operators(slot: str) -> Mapping[str, type[Any]]:
    """The operators of a slot that installed packages announce, by name; raises as `algorithms`."""
    group = f"{OPERATOR_GROUP}.{slot}"
    if not entry_points(group=group):
        return {}
    base = getattr(import_module(f"pymoo.core.{slot}"), slot.capitalize())
    return announced(group, base, taken=(), name="")


def algorithm_named(text: str) -> Any:
    """Make the pymoo algorithm that a text names, for one objective.

    Raises:
        UsageError: There is no such algorithm, or it cannot be made with these settings.
    """
    return maker_of(AlgorithmSpec.of(text))(1)


def maker_of(
    spec: AlgorithmSpec, found: Any = None, *, expected: str = EXPECTED, known: Iterable[str] = ()
) -> Callable[[int], Any]:
    """A factory of an algorithm, given the number of objectives.

    Args:
        spec: Its name and settings.
        found: Its class, an instance, or a function that returns one; the meaning of the name when absent.
        expected: What is expected, in the words of error messages.
        known: Names for the error of an unknown one; by default those that `calibrate` knows.

    Raises:
        UsageError: There is no such algorithm or operator.
    """
    usual: Mapping[str, Value] = {}
    if found is None and spec.attribute is not None:
        found = imported(spec)
    elif found is None and spec.name in algorithms():
        found, usual = imported(AlgorithmSpec.of(algorithms()[spec.name].home)), algorithms()[spec.name].usual
    elif found is None:
        found = pymoos("algorithms", spec.name)
    if found is None:
        near_ones = near(spec.name, known or [SCREENING, *algorithms(), POLISH_ONLY])
        raise UsageError(f"No algorithm '{spec.name}'.{near_ones} One of your own is package.module:attribute.")
    if not callable(found):
        found = copies(spec, found)
    parts = {slot: _operator_maker(slot, one) for slot, one in spec.operators.items()}
    given = {**usual, **spec.settings}
    return partial(_made, spec, found, given, parts, expected)


def _made(
    spec: AlgorithmSpec,
    make: Callable[..., Any],
    settings: Mapping[str, Any],
    parts: Mapping[str, Callable[[], Any]],
    expected: str,
    n_obj: int,
) -> Any:
    from pymoo.core.algorithm import Algorithm  # noqa: PLC0415 - pymoo takes a second to import

    from robolaser.operators.elitist_replacement import ElitistReplacement, refuse  # noqa: PLC0415

    operators = {slot: make() for slot, make in parts.items()}
    given = {**settings, **operators}
    if (elites := getattr(operators.get("survival"), "n_elites", 0)) and {"pop_size", "n_offsprings"} <= {
        *keywords(make)[0]
    }:
        given = {"pop_size": 100, **given}
        if elites >= given["pop_size"]:
            raise UsageError(f"{spec.text}: survival.n_elites is {elites}, expected fewer than pop_size.")
        given = {"n_offsprings": given["pop_size"] - elites, **given}
    if inspect.isclass(make) and "ref_dirs" in keywords(make)[0] and "ref_dirs" not in given:
        if n_obj == 1:
            raise UsageError(f"{spec.text} searches along reference directions, which need several objectives.")
        given["ref_dirs"] = reference_directions(n_obj)
    algorithm = made(spec, make, given)
    if not isinstance(algorithm, Algorithm):
        raise UsageError(f"{spec.text} is {named(algorithm)} and cannot search. Expected {expected}.")
    for slot, operator in operators.items():
        if not _has(algorithm, operator):
            raise UsageError(f"{spec.text}: {spec.path} has no place for another {slot}, and would run with its own.")
        if isinstance(operator, ElitistReplacement):
            try:
                refuse(algorithm)
            except AlgorithmError as error:
                raise UsageError(f"{spec.text} cannot be made. {error}") from error
    return algorithm


def reference_directions(n_obj: int) -> Any:
    """Das and Dennis's directions, about a hundred, for algorithms that need them (NSGA3, MOEAD, RVEA)."""
    from pymoo.util.ref_dirs import get_reference_directions  # noqa: PLC0415 - only some algorithms need it

    return get_reference_directions("das-dennis", n_obj, n_partitions=DIRECTIONS.get(n_obj, 3))


def _has(algorithm: Any, operator: Any) -> bool:
    """Whether an algorithm took an operator; some accept any keyword and ignore it."""
    places = [algorithm, *(getattr(algorithm, name, None) for name in ("mating", "initialization"))]
    return any(operator is held for place in places for held in getattr(place, "__dict__", {}).values())


def _operator_maker(slot: str, spec: AlgorithmSpec) -> Callable[[], Any]:
    from robolaser import operators as ours  # noqa: PLC0415 - pymoo takes a second to import

    if spec.attribute is not None:
        found = imported(spec)
    elif spec.name in operators(slot):
        found = operators(slot)[spec.name]
    else:
        found = getattr(ours, spec.name) if spec.name in ours.__all__ else pymoos("operators", spec.name)
    if found is None:
        names = [*operators(slot), *(ours.__all__ if slot != "sampling" else ())]
        raise UsageError(
            f"No {slot} '{spec.name}'.{near(spec.name, names)} One of your own is package.module:attribute."
        )
    if inspect.isclass(found) or inspect.isroutine(found):
        parts = {slot: _operator_maker(slot, one) for slot, one in spec.operators.items()}
        return partial(_operator, spec, found, parts)
    return copies(spec, found)


def _operator(spec: AlgorithmSpec, make: Callable[..., Any], parts: Mapping[str, Callable[[], Any]]) -> Any:
    return made(spec, make, {**spec.settings, **{slot: part() for slot, part in parts.items()}})


@cache
def pymoos(package: str, name: str) -> type[Any] | None:
    """A class of pymoo's `algorithms` or `operators` by its name; only its module is imported.

    Raises:
        UsageError: It needs a package that is not installed.
    """
    root = Path(str(files("pymoo")))
    for path in sorted((root / package).rglob("*.py")):
        if re.search(rf"^class {re.escape(name)}\(", path.read_text(), re.MULTILINE):
            try:
                module = import_module(".".join(path.relative_to(root.parent).with_suffix("").parts))
            except Exception as error:  # Optuna's module raises its own
                raise UsageError(f"pymoo's {name} cannot be imported ({type(error).__name__}: {error}).") from error
            found: type[Any] = getattr(module, name)
            return found
    return None
