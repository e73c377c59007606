"""Departures from the nominal model, one file each: a new file in this folder takes part without an edit."""

import importlib
import pkgutil
from collections.abc import Iterable, Sequence
from functools import cache
from typing import Any, Final

from robolaser.data.dataset import Dataset
from robolaser.errors import EffectError, UsageError, near
from robolaser.model.effects import outliers
from robolaser.model.effects.effect import CandidateEffect, Effect
from robolaser.model.effects.sensor_sites import kind_of_site
from robolaser.plugins import announced
from robolaser.robot.kinematics import Robot

GROUP: Final = "robolaser.effects"  # entry points under which installed packages announce effects
DECLARED: Final = ("title", "reference", "stage")  # declared by every subclass, besides its name and abstract methods
BESIDE_THE_LIBRARY: Final = ("gravity_direction", "held_parameter", "mispaired", outliers.NAME, "pose_scatter")

EFFECTS: tuple[type[Effect], ...]
"""Every effect that comes with the package, and those that other installed packages announce, by name.

Examples:
    >>> [effect.name for effect in robolaser.EFFECTS][:3]
    ['arm_scale', 'backlash', 'base_compliance']
"""


@cache
def _library() -> tuple[type[Effect], ...]:
    for module in pkgutil.iter_modules(__path__):
        importlib.import_module(f"{__name__}.{module.name}")
    ours = [effect for effect in _final(Effect) if effect.__module__.startswith(f"{__name__}.")]
    others = announced(GROUP, Effect, taken=[effect.name for effect in ours], required=DECLARED)
    return tuple(sorted({*ours, *others.values()}, key=lambda effect: effect.name))


def _final(kind: type[Effect]) -> list[type[Effect]]:
    """The effects below an abstract one, or itself."""
    below = kind.__subclasses__()
    return [effect for child in below for effect in _final(child)] if below else [kind]


def __getattr__(name: str) -> Any:
    """Load the effects when they are first needed: a package that brings one imports this module itself.

    Raises:
        PluginError: What an installed package announces cannot be used.
    """
    if name != "EFFECTS":
        raise AttributeError(f"module '{__name__}' has no attribute '{name}'")
    return _library()


def candidate_effects(wanted: Sequence[str | type[Effect]], dataset: Dataset) -> tuple[CandidateEffect, ...]:
    """Read `EFFECT[:WHERE]`, or a class; without WHERE it is meant at every location that the data set has for it.

    Raises:
        UsageError: There is no such effect, it cannot be at that location or in a model, or a size is stated.
        EffectError: It does not apply to the data.
        PluginError: What an installed package announces cannot be used.
    """
    by_name = {effect.name: effect for effect in (*_library(), *(one for one in wanted if not isinstance(one, str)))}
    chosen: list[CandidateEffect] = []
    for text in (one if isinstance(one, str) else one.name for one in wanted):
        name, _, where = text.partition(":")
        if "=" in text:
            raise UsageError(
                f"'{text}' states a size, but only a name is expected here: write {text.partition('=')[0]}."
            )
        if name not in by_name:
            raise unknown_effect(name, by_name)
        effect = by_name[name]
        locations = effect.locations(dataset)
        if not locations:
            raise EffectError(f"{name} does not apply to these data: {effect.missing(dataset)}.")
        if where and where not in locations:
            raise unknown_location(name, where, locations)
        chosen += [CandidateEffect(effect, location) for location in ([where] if where else locations)]
    return tuple(dict.fromkeys(chosen))


def found_effect(name: str, where: str, robot: Robot | None) -> CandidateEffect:
    """An effect of a saved model, whether or not other data can test it.

    Raises:
        UsageError: There is no such effect, or the arm has no such location.
    """
    by_name = {effect.name: effect for effect in _library()}
    if name not in by_name:
        raise unknown_effect(name, by_name)
    locations = by_name[name].sites(robot)
    if kind_of_site(where) not in locations:
        raise unknown_location(name, where, locations)
    return CandidateEffect(by_name[name], where)


def unknown_effect(name: str, known: Iterable[str]) -> UsageError:
    """No effect of the library has that name."""
    if name in BESIDE_THE_LIBRARY:
        return UsageError(f"{name} cannot be added to a model, nor left out: every diagnosis looks for it.")
    return UsageError(f"No effect '{name}'.{near(name, known)}")


def unknown_location(name: str, where: str, known: Iterable[str]) -> UsageError:
    """The effect exists, but not at that location."""
    return UsageError(f"{name} cannot be at '{where}'.{near(where, known)}")
