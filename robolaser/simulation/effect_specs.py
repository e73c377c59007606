"""The requested effects of a simulated cell: from texts to numbers."""

from collections.abc import Iterable, Mapping

import numpy as np

from robolaser.data.dataset import Dataset
from robolaser.errors import UsageError
from robolaser.model.effects import candidate_effects, unknown_location
from robolaser.model.effects.effect import CandidateEffect, Effect


def sizes_of(texts: Iterable[str]) -> dict[str, float]:
    """Read `NAME[:WHERE]=SIZE`, the size in SI units.

    Raises:
        UsageError: There is no size, or two, or it is not a finite number.

    Examples:
        >>> from robolaser.simulation import sizes_of
        >>> sizes_of(["laser_roll=0.03", "backlash:joint_2=0.001"])
        {'laser_roll': 0.03, 'backlash:joint_2': 0.001}
    """
    sizes: dict[str, float] = {}
    for text in texts:
        name, _, size = text.rpartition("=")
        try:
            value = float(size)
        except ValueError:
            raise _unclear(text) from None
        if not name or "=" in name or not np.isfinite(value):
            raise _unclear(text)
        if name in sizes:
            raise UsageError(f"{name} is stated twice, with {sizes[name]:g} and {value:g}. State one size.")
        sizes[name] = value
    return sizes


def _unclear(text: str) -> UsageError:
    return UsageError(
        f"'{text}' does not state an effect and its size: expected NAME[:WHERE]=SIZE in SI units, such as"
        " joint_offset:joint_2=0.002."
    )


def numbers_of(sizes: Mapping[str, float], dataset: Dataset) -> tuple[tuple[CandidateEffect, ...], dict[str, float]]:
    """The requested effects, and all their numbers by name: unstated ones are nominal.

    Sizes are by NAME[:WHERE[.NUMBER]]: without NUMBER the principal one, without WHERE at every location of the cell.

    Raises:
        UsageError: There is no such effect or location, or the effect cannot be of this size.
        EffectError: It does not apply to the cell.
    """
    chosen: dict[CandidateEffect, None] = {}
    numbers: dict[str, float] = {}
    for key, size in sizes.items():
        name, _, where = key.partition(":")
        everywhere = candidate_effects([name], dataset)
        effect = everywhere[0].effect
        known = list(effect.units())
        number = known[0]
        if where not in {one.where for one in everywhere}:
            location, _, last = where.rpartition(".")
            where, number = (location, last) if location and last in known else (where, number)
        there = [one for one in everywhere if not where or one.where == where]
        if not there:
            raise unknown_location(name, where, [one.where for one in everywhere])
        _check(effect, number, size)
        for one in there:
            if one not in chosen:
                chosen[one] = None
                numbers |= {item.name: item.nominal for item in one.parameters.items}
                shape = effect.usual_shape(dataset, one.where)
                numbers |= {one.key(inner): value for inner, value in shape.items()}
            numbers[one.key(number)] = float(size)
    return tuple(chosen), numbers


def _check(effect: type[Effect], name: str, size: float) -> None:
    bounds = {each.name: (each.lower, each.bound) for each in effect.amplitudes()}
    bounds |= {inner.name: (inner.lower, inner.upper) for inner in effect.nonlinear_parameters()}
    (lower, upper), unit = bounds[name], effect.units()[name]
    if not lower <= size <= upper:
        hint = {"rad": " Are these degrees?", "m": " Are these millimetres?"}.get(unit, "") if abs(size) > upper else ""
        between, unit = f"±{upper:g}" if lower == -upper else f"{lower:g} and {upper:g}", f" {unit}".rstrip()
        raise UsageError(f"{effect.name}: {name} is {size:g}{unit}, but its bounds are {between}{unit}.{hint}")
