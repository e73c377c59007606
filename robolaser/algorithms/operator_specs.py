"""Operators by word, to be put into pymoo's genetic algorithm in the place of its own."""

from collections.abc import Callable, Mapping
from dataclasses import dataclass
from typing import Any, final

from robolaser.algorithms.lazy import lazily
from robolaser.algorithms.settings import Setting, Value, number, share, whole, word


@final
@dataclass(frozen=True)
class Part:
    """An operator by its word: how to make it, and what its maker understands."""

    make: Callable[..., Any]
    settings: tuple[Setting, ...] = ()


def _tournament() -> Any:
    from pymoo.algorithms.soo.nonconvex.ga import comp_by_cv_and_fitness  # noqa: PLC0415 - pymoo takes a second to import
    from pymoo.operators.selection.tournament import TournamentSelection  # noqa: PLC0415

    return TournamentSelection(func_comp=comp_by_cv_and_fitness)


_CROSSOVER, _MUTATION = "pymoo.operators.crossover", "pymoo.operators.mutation"
_PROB = share("prob")

PARTS: Mapping[str, Mapping[str, Part]] = {
    "crossover": {
        "sbx": Part(lazily(f"{_CROSSOVER}.sbx", "SBX"), (_PROB, share("prob_var"), number("eta", 1.0))),
        "arithmetic": Part(lazily("robolaser.operators", "ArithmeticCrossover"), (_PROB,)),
        "pcx": Part(lazily(f"{_CROSSOVER}.pcx", "PCX"), (_PROB, number("eta"), number("zeta"))),
        "de": Part(lazily(f"{_CROSSOVER}.dex", "DEX"), (number("F"), share("CR"))),
        "uniform": Part(lazily(f"{_CROSSOVER}.ux", "UX"), (_PROB,)),
        "exponential": Part(lazily(f"{_CROSSOVER}.expx", "ExponentialCrossover"), (_PROB, share("prob_exp"))),
    },
    "mutation": {
        "polynomial": Part(lazily(f"{_MUTATION}.pm", "PM"), (_PROB, share("prob_var"), number("eta", 1.0))),
        "non-uniform": Part(
            lazily("robolaser.operators", "NonUniformMutation"),
            (_PROB, share("prob_var"), number("b"), word("form", ("linear", "power"))),
        ),
        "gaussian": Part(lazily(f"{_MUTATION}.gauss", "GaussianMutation"), (_PROB, share("prob_var"), share("sigma"))),
    },
    "selection": {
        "tournament": Part(_tournament),
        "roulette": Part(lazily("robolaser.operators", "RouletteSelection")),
        "random": Part(lazily("pymoo.operators.selection.rnd", "RandomSelection")),
    },
    "survival": {
        "fitness": Part(lazily("pymoo.algorithms.soo.nonconvex.ga", "FitnessSurvival")),
        "elitist": Part(lazily("robolaser.operators", "ElitistReplacement", n_elites=10), (whole("n_elites", 0),)),
    },
}
"""By place and word; pymoo's own first."""


def settings_of_parts(given: Mapping[str, Value]) -> list[Setting]:
    """What can be said of the parts: a word for each place, and `place.key` for the settings of what is there."""
    known = []
    for place, parts in PARTS.items():
        part = parts.get(str(given.get(place, next(iter(parts)))))
        known += [word(place, parts), *(setting.of(place) for setting in (part.settings if part else ()))]
    return known


def made_parts(given: Mapping[str, Value]) -> dict[str, Any]:
    """The operators that settings speak of, by their places; and what the settings say besides."""
    made: dict[str, Any] = {}
    for name, value in given.items():
        place = name.partition(".")[0]
        if place not in PARTS:
            made[name] = value
        elif place not in made:
            parts = PARTS[place]
            own = {key.removeprefix(f"{place}."): said for key, said in given.items() if key.startswith(f"{place}.")}
            made[place] = parts[str(given.get(place, next(iter(parts))))].make(**own)
    return made
