"""Departures from the nominal model, one file each: a new file in this folder takes part without an edit."""

import importlib
import pkgutil
from collections.abc import Sequence
from functools import cache
from typing import Any, Final

from robolaser.data.dataset import Dataset
from robolaser.errors import EffectBendsNothing, EffectSenseless, EffectUnknown, PlaceUnknown
from robolaser.model.effects import outliers
from robolaser.model.effects.effect import CandidateEffect, Effect
from robolaser.plugins import announced

GROUP: Final = "robolaser.effects"
"""Entry points under which installed packages announce effects."""
DECLARED: Final = ("title", "reference", "stage")
"""What a subclass must say besides its name and what is abstract."""

EFFECTS: tuple[type[Effect], ...]
"""Every effect that comes with the package, and those that other installed packages announce, by name."""


@cache
def _library() -> tuple[type[Effect], ...]:
    for module in pkgutil.iter_modules(__path__):
        importlib.import_module(f"{__name__}.{module.name}")
    ours = [kind for kind in Effect.__subclasses__() if kind.__module__.startswith(f"{__name__}.")]
    others = announced(GROUP, Effect, taken=[kind.name for kind in ours], required=DECLARED)
    return tuple(sorted((*ours, *others.values()), key=lambda kind: kind.name))


def __getattr__(name: str) -> Any:
    """Load the effects when they are first asked for: a package that brings one imports this module itself.

    Raises:
        PluginError: What an installed package announces cannot be used.
    """
    if name != "EFFECTS":
        raise AttributeError(f"module '{__name__}' has no attribute '{name}'")
    return _library()


def candidate_effects(wanted: Sequence[str], dataset: Dataset) -> tuple[CandidateEffect, ...]:
    """Read `EFFECT[:WHERE]`; without WHERE it is meant at every place that the data set has for it.

    Raises:
        EffectUnknown: No such effect.
        EffectBendsNothing: It is a finding, and no part of a model.
        EffectSenseless: The data set's robot or sensor has no place for it.
        PlaceUnknown: It cannot sit there.
        PluginError: What an installed package announces cannot be used.
    """
    by_name = {kind.name: kind for kind in _library()}
    chosen: list[CandidateEffect] = []
    for text in wanted:
        name, _, where = text.partition(":")
        if name == outliers.NAME:
            raise EffectBendsNothing(name)
        if name not in by_name:
            raise EffectUnknown(name, by_name)
        kind = by_name[name]
        places = kind.places(dataset)
        if not places:
            raise EffectSenseless(name, kind.missing(dataset))
        if where and where not in places:
            raise PlaceUnknown(name, where, places)
        chosen += [CandidateEffect(kind, place) for place in ([where] if where else places)]
    return tuple(dict.fromkeys(chosen))
