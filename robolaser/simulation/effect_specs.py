"""The effects that a simulated cell is asked to have: from texts to numbers."""

from collections.abc import Iterable, Mapping

import numpy as np

from robolaser.data.dataset import Dataset
from robolaser.errors import EffectSizeUnclear, EffectTooLarge, PlaceUnknown, ShapeOutside
from robolaser.model.effects import candidate_effects
from robolaser.model.effects.effect import CandidateEffect, Effect


def sizes_of(texts: Iterable[str]) -> dict[str, float]:
    """Read `NAME[:WHERE]=SIZE`, the size in SI units.

    Raises:
        EffectSizeUnclear: There is no size, or it is not a finite number.
    """
    sizes = {}
    for text in texts:
        name, _, size = text.rpartition("=")
        try:
            value = float(size)
        except ValueError:
            raise EffectSizeUnclear(text) from None
        if not name or not np.isfinite(value):
            raise EffectSizeUnclear(text)
        sizes[name] = value
    return sizes


def numbers_of(sizes: Mapping[str, float], dataset: Dataset) -> tuple[tuple[CandidateEffect, ...], dict[str, float]]:
    """The effects asked for, and all their numbers by name: what is not asked for is nominal.

    Args:
        sizes: By NAME[:WHERE[.NUMBER]]: without NUMBER the principal one, without WHERE at every place.
        dataset: The cell, with poses and without points.

    Raises:
        EffectUnknown, EffectSenseless, PlaceUnknown: The cell cannot have the effect.
        EffectTooLarge, ShapeOutside: It cannot have this size.
    """
    chosen: dict[CandidateEffect, None] = {}
    numbers: dict[str, float] = {}
    for key, size in sizes.items():
        name, _, where = key.partition(":")
        everywhere = candidate_effects([name], dataset)
        kind = everywhere[0].kind
        known = [number for number, *_ in kind.declared()] + [number for number, *_ in kind.shapes()]
        number = known[0]
        if where not in {candidate_effect.where for candidate_effect in everywhere}:
            place, _, last = where.rpartition(".")
            where, number = (place, last) if place and last in known else (where, number)
        there = [candidate_effect for candidate_effect in everywhere if not where or candidate_effect.where == where]
        if not there:
            raise PlaceUnknown(name, where, [candidate_effect.where for candidate_effect in everywhere])
        _check(kind, number, size)
        for candidate_effect in there:
            if candidate_effect not in chosen:
                chosen[candidate_effect] = None
                numbers |= {item.name: item.nominal for item in candidate_effect.parameters.items}
            numbers[candidate_effect.key(number)] = float(size)
    return tuple(chosen), numbers


def _check(kind: type[Effect], number: str, size: float) -> None:
    for name, unit, bound, _ in kind.declared():
        if name == number and not abs(size) <= bound:
            raise EffectTooLarge(kind.name, number, size, bound, unit)
    for name, unit, lower, upper, _ in kind.shapes():
        if name == number and not lower <= size <= upper:
            raise ShapeOutside(kind.name, number, size, lower, upper, unit)
