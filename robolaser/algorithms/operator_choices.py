"""Operators by name, which replace those of pymoo's genetic algorithm."""

from collections.abc import Callable, Mapping
from dataclasses import dataclass
from functools import cache
from importlib import import_module
from importlib.metadata import entry_points
from typing import Any, final

from robolaser.algorithms.lazy import lazy_factory
from robolaser.algorithms.settings import Setting, Value, number, share, whole, word
from robolaser.algorithms.user_code import keywords
from robolaser.plugins import announced

GROUP = "robolaser.operators"
"""Entry points of installed packages are `robolaser.operators.crossover` and so on, by slot."""


@final
@dataclass(frozen=True)
class OperatorChoice:
    """An operator by its name: its factory, and the settings that this takes."""

    make: Callable[..., Any]
    settings: tuple[Setting, ...] = ()


def _tournament() -> Any:
    from pymoo.algorithms.soo.nonconvex.ga import comp_by_cv_and_fitness  # noqa: PLC0415 - pymoo takes a second to import
    from pymoo.operators.selection.tournament import TournamentSelection  # noqa: PLC0415

    return TournamentSelection(func_comp=comp_by_cv_and_fitness)


_CROSSOVER, _MUTATION = "pymoo.operators.crossover", "pymoo.operators.mutation"
_PROB = share("prob")

OPERATORS: Mapping[str, Mapping[str, OperatorChoice]] = {
    "crossover": {
        "sbx": OperatorChoice(lazy_factory(f"{_CROSSOVER}.sbx", "SBX"), (_PROB, share("prob_var"), number("eta", 1.0))),
        "arithmetic": OperatorChoice(lazy_factory("robolaser.operators", "ArithmeticCrossover"), (_PROB,)),
        "pcx": OperatorChoice(lazy_factory(f"{_CROSSOVER}.pcx", "PCX"), (_PROB, number("eta"), number("zeta"))),
        "de": OperatorChoice(lazy_factory(f"{_CROSSOVER}.dex", "DEX"), (number("F"), share("CR"))),
        "uniform": OperatorChoice(lazy_factory(f"{_CROSSOVER}.ux", "UX"), (_PROB,)),
        "exponential": OperatorChoice(
            lazy_factory(f"{_CROSSOVER}.expx", "ExponentialCrossover"), (_PROB, share("prob_exp"))
        ),
    },
    "mutation": {
        "polynomial": OperatorChoice(
            lazy_factory(f"{_MUTATION}.pm", "PM"), (_PROB, share("prob_var"), number("eta", 1.0))
        ),
        "non-uniform": OperatorChoice(
            lazy_factory("robolaser.operators", "NonUniformMutation"),
            (_PROB, share("prob_var"), number("b"), word("form", ("linear", "power"))),
        ),
        "gaussian": OperatorChoice(
            lazy_factory(f"{_MUTATION}.gauss", "GaussianMutation"), (_PROB, share("prob_var"), share("sigma"))
        ),
    },
    "selection": {
        "tournament": OperatorChoice(_tournament),
        "roulette": OperatorChoice(lazy_factory("robolaser.operators", "RouletteSelection")),
        "random": OperatorChoice(lazy_factory("pymoo.operators.selection.rnd", "RandomSelection")),
    },
    "survival": {
        "fitness": OperatorChoice(lazy_factory("pymoo.algorithms.soo.nonconvex.ga", "FitnessSurvival")),
        "elitist": OperatorChoice(
            lazy_factory("robolaser.operators", "ElitistReplacement", n_elites=10), (whole("n_elites", 0),)
        ),
    },
}
"""By slot and name; pymoo's defaults first."""


def operator_settings(given: Mapping[str, Value]) -> list[Setting]:
    """Settings that choose operators: a name for each slot, and `slot.key` for the settings of the operator in it."""
    known = []
    for slot, choices in operators().items():
        chosen = choices.get(str(given.get(slot, next(iter(choices)))))
        known += [word(slot, choices), *(setting.of(slot) for setting in (chosen.settings if chosen else ()))]
    return known


def with_operators(given: Mapping[str, Value]) -> dict[str, Any]:
    """Replace the settings of operators by the operators themselves, by slot; other settings stay."""
    made: dict[str, Any] = {}
    for name, value in given.items():
        slot = name.partition(".")[0]
        if slot not in OPERATORS:
            made[name] = value
        elif slot not in made:
            choices = operators()[slot]
            own = {key.removeprefix(f"{slot}."): set_ for key, set_ in given.items() if key.startswith(f"{slot}.")}
            made[slot] = choices[str(given.get(slot, next(iter(choices))))].make(**own)
    return made


@cache
def operators() -> Mapping[str, Mapping[str, OperatorChoice]]:
    """Our operators and those that installed packages announce under `robolaser.operators.SLOT`, by slot and name.

    Raises:
        PluginError: What a package announces cannot be used.
    """
    groups = entry_points().groups
    found: dict[str, Mapping[str, OperatorChoice]] = {}
    for slot, choices in OPERATORS.items():
        group = f"{GROUP}.{slot}"
        theirs: Mapping[str, type[Any]] = {}
        if group in groups:
            base = getattr(import_module(f"pymoo.core.{slot}"), slot.capitalize())
            theirs = announced(group, base, taken=choices, name="")
        found[slot] = {**choices, **{name: OperatorChoice(kind, _settings(kind)) for name, kind in theirs.items()}}
    return found


def _settings(kind: type[Any]) -> tuple[Setting, ...]:
    """The arguments of an operator that a package announces; only it knows which values make sense."""
    return tuple(Setting(name, "", lambda value: True) for name in keywords(kind)[0])
