"""The parameters as rows of a table: value and error, position within the bounds, and caveats."""

from collections.abc import Sequence
from dataclasses import dataclass
from typing import final

import numpy as np

from robolaser.calibration.result import Calibration
from robolaser.report.calibration.meanings import effect_meaning, meaning
from robolaser.report.digits import measured, plain

FIXED, ON_BOUND, UNDETERMINED = "fixed", "on its bound", "not determined by these data"
CORRELATED = "hardly distinguishable from others"
BAND = 2.0  # standard deviations of the band on the bounds bar


@final
@dataclass(frozen=True)
class Bar:
    """Where a value lies within its bounds, in per cent of the way from lower to upper.

    Attributes:
        value: The value.
        nominal: The nominal value.
        start: Lower end of the value's band of two standard deviations.
        length: Of that band.
        lower: Lower bound for people.
        upper: Upper bound for people.
    """

    value: float
    nominal: float
    start: float
    length: float
    lower: str
    upper: str


@final
@dataclass(frozen=True)
class ParameterRow:
    """One parameter.

    Attributes:
        name: As in files.
        meaning: In a few words.
        value: With its error and unit.
        nominal: With unit; empty where nobody gave one.
        bar: None where nobody gave bounds.
        note: A caveat; may be empty.
    """

    name: str
    meaning: str
    value: str
    nominal: str
    bar: Bar | None
    note: str


@final
@dataclass(frozen=True)
class EffectParameterRow:
    """One number of an effect in the model.

    Attributes:
        effect: Its name.
        where: Its place.
        meaning: In a few words.
        number: Which of the effect's numbers.
        value: With its error and unit.
        away: How far it is from zero.
        note: A caveat; may be empty.
    """

    effect: str
    where: str
    meaning: str
    number: str
    value: str
    away: str
    note: str


def parameter_rows(calibration: Calibration) -> tuple[Sequence[ParameterRow], Sequence[ParameterRow]]:
    """The sensor's parameters: those with bounds from the user, and those that started from a closed form."""
    model = calibration.model
    given: list[ParameterRow] = []
    placed: list[ParameterRow] = []
    for i, item in enumerate(model.parameters.items[: len(model.parameters) - len(model.effect_parameters)]):
        value, std = float(calibration.x[i]), float(calibration.std[i])
        bar = None
        if item.given and not item.fixed:
            width = item.upper - item.lower
            at, nominal = (100 * (number - item.lower) / width for number in (value, item.nominal))
            half = 100 * BAND * std / width if np.isfinite(std) else 0.0
            start, end = (float(np.clip(end, 0, 100)) for end in (at - half, at + half))
            bar = Bar(at, nominal, start, end - start, plain(item.lower, item.unit), plain(item.upper, item.unit))
        row = ParameterRow(
            name=item.name,
            meaning=meaning(item.name),
            value=measured(value, std, item.unit),
            nominal=plain(item.nominal, item.unit) if item.given else "",
            bar=bar,
            note=note(calibration, i),
        )
        (given if item.given else placed).append(row)
    return given, placed


def effect_rows(calibration: Calibration) -> Sequence[EffectParameterRow]:
    """The numbers of the effects in the model."""
    names = calibration.model.parameters.names
    rows = []
    for candidate_effect in calibration.model.effects:
        for item in candidate_effect.parameters.items:
            i = names.index(item.name)
            value, std = float(calibration.x[i]), float(calibration.std[i])
            rows.append(
                EffectParameterRow(
                    effect=candidate_effect.effect.name,
                    where=candidate_effect.where,
                    meaning=effect_meaning(candidate_effect.effect.name),
                    number=item.name.rpartition(".")[2],
                    value=measured(value, std, item.unit),
                    away=f"{abs(value) / std:.1f}" if np.isfinite(std) and std > 0 else "",
                    note=note(calibration, i),
                )
            )
    return rows


def note(calibration: Calibration, i: int) -> str:
    """The caveat about the i-th parameter; may be empty."""
    name = calibration.model.parameters.names[i]
    if name in calibration.model.sensor.held:
        return FIXED
    if calibration.on_bound[i]:
        return ON_BOUND
    if not np.isfinite(calibration.std[i]):
        return UNDETERMINED
    held = set(calibration.model.sensor.fixed)
    shared = [set(direction.parameters) for direction in calibration.unidentifiable if name in direction.parameters]
    if any(not held & names for names in shared):
        return CORRELATED
    item = calibration.model.parameters.items[i]
    started = "" if item.given or not item.origin else f"started from {item.origin}"
    return f"given {' and '.join(sorted(held))}" if shared else started
