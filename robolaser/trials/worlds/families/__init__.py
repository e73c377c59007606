"""Families of departures, one file each: those that the library names, and strangers that it lacks."""

import importlib
import pkgutil

from robolaser.trials.worlds.departure import Departure


def _all() -> tuple[type[Departure], ...]:
    for module in pkgutil.iter_modules(__path__):
        importlib.import_module(f"{__name__}.{module.name}")
    return tuple(sorted(Departure.__subclasses__(), key=lambda family: family.effect))


GROSS = "outliers"

FAMILIES: dict[str, type[Departure]] = {family.effect: family for family in _all()}
"""By the name that truth uses."""

STRANGERS: tuple[str, ...] = ("cross_talk", "dented_target", "hose")
"""What a diagnosis should call unexplained."""

KNOWN: tuple[str, ...] = tuple(name for name in FAMILIES if name not in STRANGERS and name != GROSS)
"""What a diagnosis should name."""
