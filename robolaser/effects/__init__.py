"""Departures from the nominal model, one file each: a new file in this folder takes part without an edit."""

import importlib
import pkgutil
from collections.abc import Sequence

from robolaser.dataset import Dataset
from robolaser.effects import outliers
from robolaser.effects.effect import Effect, Suspect
from robolaser.errors import EffectBendsNothing, EffectSenseless, EffectUnknown, PlaceUnknown


def _library() -> tuple[type[Effect], ...]:
    for module in pkgutil.iter_modules(__path__):
        importlib.import_module(f"{__name__}.{module.name}")
    return tuple(sorted(Effect.__subclasses__(), key=lambda kind: kind.name))


EFFECTS: tuple[type[Effect], ...] = _library()
"""Every effect that comes with the package."""


def suspects(wanted: Sequence[str], dataset: Dataset) -> tuple[Suspect, ...]:
    """Read `EFFECT[:WHERE]`; without WHERE it is meant at every place that the data set has for it.

    Raises:
        EffectUnknown: No such effect.
        EffectBendsNothing: It is a finding, and no part of a model.
        EffectSenseless: The data set's robot or sensor has no place for it.
        PlaceUnknown: It cannot sit there.
    """
    by_name = {kind.name: kind for kind in EFFECTS}
    chosen: list[Suspect] = []
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
        chosen += [Suspect(kind, place) for place in ([where] if where else places)]
    return tuple(dict.fromkeys(chosen))
