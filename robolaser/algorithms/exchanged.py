"""Algorithms with exchanged operators: `STOCK+slot=OPERATOR`, as in `GA+crossover=ArithmeticCrossover:prob=0.85`.

The stock is an algorithm by any of its names, or a class of pymoo's by its own; an operator is one of those that `ga`
knows by name, a class of `robolaser.operators` or of pymoo's, or `package.module:attribute`.
"""

import copy
import inspect
import re
from collections.abc import Callable, Mapping
from functools import cache, partial
from importlib import import_module
from importlib.resources import files
from pathlib import Path
from typing import Any

from robolaser import operators as ours
from robolaser.algorithms.algorithm_spec import AlgorithmSpec
from robolaser.algorithms.operator_choices import operators
from robolaser.algorithms.registry import algorithms
from robolaser.algorithms.settings import check, not_made
from robolaser.algorithms.user_code import imported, made_with, no_settings
from robolaser.errors import AlgorithmError, UsageError, near
from robolaser.operators.elitist_replacement import refuse

SLOTS = ("sampling", "selection", "crossover", "mutation", "survival", "repair")  # what can be exchanged
_PART = re.compile(rf"\+(?=(?:{'|'.join(SLOTS)})=)")


def parted(text: str) -> tuple[str, dict[str, str]]:
    """The stock algorithm and its exchanged operators, by slot.

    Raises:
        UsageError: A slot is exchanged twice.
    """
    stock, *parts = _PART.split(text)
    pairs = [tuple(part.split("=", 1)) for part in parts]
    if len(dict(pairs)) < len(pairs):
        raise UsageError(f"{text}: an operator is exchanged twice. Name each of them once.")
    return stock, dict(pairs)


def joined(stock: str, parts: Mapping[str, str]) -> str:
    """The text of an algorithm and its exchanged operators, each as short as it can be named."""
    return "".join([stock, *(f"+{slot}={shortened(slot, name)}" for slot, name in parts.items() if name)])


def shortened(slot: str, text: str) -> str:
    """An operator's text without its module, where the class is found without."""
    spec = AlgorithmSpec.of(text)
    if spec.attribute is None or _known(slot, spec.attribute) is not imported(spec):
        return text
    return text.removeprefix(f"{spec.name}:")


def stock_class(name: str) -> type[Any] | None:
    """A class of pymoo's algorithms by its name, if there is one."""
    return _of_pymoo("algorithms", name)


def make_exchanged(text: str) -> Callable[[], Any]:
    """What makes the algorithm.

    Raises:
        UsageError: There is no such algorithm or operator, or it has no place for one.
    """
    stock, parts = parted(text)
    spec = AlgorithmSpec.of(stock)
    makers = {slot: _operator(slot, name) for slot, name in parts.items()}
    found: Any = imported(spec) if spec.attribute is not None else stock_class(spec.name)
    if spec.attribute is None and spec.name in algorithms():
        named = algorithms()[spec.name]
        if named.settings is not None:
            check(spec.name, spec.settings, named.settings)
        found = named.make
    if not callable(found):
        raise UsageError(
            f"{text}: the operators of {stock} cannot be exchanged. Expected the name of one of pymoo's algorithms, or"
            " a class or function of your own that takes operators."
        )

    def make() -> Any:
        own = {slot: make() for slot, make in makers.items()}
        settings: dict[str, Any] = {**spec.settings, **own}
        algorithm = made_with(AlgorithmSpec(text, spec.name, spec.attribute, settings), found)
        for slot, operator in own.items():
            if not _has(algorithm, operator):
                raise UsageError(f"{text}: {stock} has no place for another {slot}, and would run with its own.")
            if isinstance(operator, ours.ElitistReplacement):
                try:
                    refuse(algorithm)
                except AlgorithmError as error:
                    raise not_made(text, error) from error
        return algorithm

    make()
    return make


def _has(algorithm: Any, operator: Any) -> bool:
    """Whether an algorithm took an operator; some accept any keyword and ignore it."""
    places = [algorithm, *(getattr(algorithm, name, None) for name in ("mating", "initialization"))]
    return any(operator is held for place in places for held in getattr(place, "__dict__", {}).values())


def _operator(slot: str, text: str) -> Callable[[], Any]:
    spec = AlgorithmSpec.of(text)
    found = imported(spec) if spec.attribute is not None else _known(slot, spec.name)
    if found is None:
        names = [*operators().get(slot, ()), *(ours.__all__ if slot != "sampling" else ())]
        raise UsageError(
            f"No {slot} '{spec.name}'.{near(spec.name, names)} One of your own is package.module:attribute."
        )
    if inspect.isclass(found) or inspect.isroutine(found):
        return partial(made_with, spec, found)
    made_with(spec, no_settings)
    return partial(copy.deepcopy, found)


def _known(slot: str, name: str) -> Any:
    """What a name without a module means."""
    choice = operators().get(slot, {}).get(name)
    if choice is not None:
        return choice.make
    return getattr(ours, name) if name in ours.__all__ else _of_pymoo("operators", name)


@cache
def _of_pymoo(package: str, name: str) -> type[Any] | None:
    """A class by its name in any module below a package; only its module is imported."""
    root = Path(str(files("pymoo")))
    for path in sorted((root / package).rglob("*.py")):
        if re.search(rf"^class {re.escape(name)}\(", path.read_text(), re.MULTILINE):
            module = ".".join(path.relative_to(root.parent).with_suffix("").parts)
            found: type[Any] = getattr(import_module(module), name)
            return found
    return None
