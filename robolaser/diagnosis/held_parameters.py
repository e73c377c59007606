"""Parameters that the data set fixes, or narrowly bounds, at wrong values, and known distances that are wrong."""

from collections.abc import Callable, Collection, Mapping, Sequence, Set
from dataclasses import replace
from typing import Final

import numpy as np

from robolaser.calibration.calibrate import calibrated
from robolaser.calibration.plan import Plan
from robolaser.calibration.result import Calibration
from robolaser.data.dataset import Dataset
from robolaser.diagnosis.cause_classes import class_of
from robolaser.diagnosis.cause_words import NAMED, listed, members
from robolaser.diagnosis.contradicted_distance import DISTANCE, ContradictedDistance
from robolaser.diagnosis.result import Diagnosis, Estimate, WrongInput
from robolaser.diagnosis.summary_text import millimetres
from robolaser.diagnosis.thresholds import SIGMA_OF_95_PERCENT, SMALL_SHARE
from robolaser.diagnosis.wrong_input import fall_in_sigmas, probability_of, squares, squares_within, with_fault
from robolaser.errors import RobolaserError
from robolaser.estimation.certainty import CERTAIN, EVEN, LIKELY
from robolaser.estimation.linearization import TOUCH
from robolaser.estimation.noise_estimate import NOISE_CONTRADICTED_SIGMA
from robolaser.model.blocks.block import LASER, THINGS
from robolaser.model.effects.effect import CandidateEffect
from robolaser.model.forward_model import Model
from robolaser.parameters import Parameter

PARTS: Final[Mapping[str, str]] = {
    **dict.fromkeys(LASER, "laser"),
    **dict.fromkeys(("w", "phi", "psi", "t_x", "t_y", "t_z", "hand_eye"), "hand_eye"),
    **dict.fromkeys(("target", "socket", "ball"), "target"),
    "base": "base",
    "tool": "tool",
}
"""The sensor's part of a parameter, by the first part of its name; all others are the camera's."""

MOST_WRONG: Final = 4.0  # ratio, either way, of a right value to a wrongly held one


def with_parameters_free(found: Diagnosis, examine: Callable[[Dataset], Diagnosis], seed: int) -> Diagnosis:
    """The diagnosis with one part's held parameters free, if that explains more, or as much as all effects found.

    Args:
        found: The diagnosis with these parameters as in the data set: fixed, or on a bound.
        examine: Diagnoses another data set in the same way.
        seed: Assigns poses to folds.
    """
    if found.hindrance:
        return found
    held, off = _held(found), ContradictedDistance.of(found.weighed.final)
    if off:
        held.setdefault(_part(off.key, found.dataset), {})[off.key] = off.stated_m
    others = {part: tuple(one for one in found.model.effects if class_of(one) != _cause(part)) for part in held}
    suspects = _suspects(found, held, {part: [kept] for part, kept in others.items()}, SIGMA_OF_95_PERCENT, seed, off)
    is_equivalent = not suspects
    if is_equivalent:  # they may do what all effects of other parts do, or one of them
        fewer = {part: _fewer(kept) for part, kept in others.items() if kept and kept == found.model.effects}
        suspects = _suspects(found, held, fewer, -SIGMA_OF_95_PERCENT, seed)
    if not suspects:
        return found
    part = min(suspects, key=lambda part: suspects[part].held_out_rms_m or np.inf)
    free = examine(suspects[part].model.dataset)
    own = off if off and off.key in held[part] else None
    would_be = {name: _would_be(free, name, own) for name in held[part]}
    moved = {name: abs(one.value - held[part][name]) / (one.std or np.inf) for name, one in would_be.items()}
    if max(moved.values()) <= NOISE_CONTRADICTED_SIGMA or _may_imitate(found, free):
        return found
    probability = min(probability_of(found, free, own.log_odds if own else 0.0), LIKELY if is_equivalent else 1.0)
    if round(probability, 2) < EVEN:  # of equal ones, the fixed number: it costs no effect
        return found
    least = min(SIGMA_OF_95_PERCENT, max(moved.values()))
    shown = {name: one for name, one in would_be.items() if moved[name] >= least}
    return _reported(found, free, part, {name: held[part][name] for name in shown}, shown, probability)


def _may_imitate(found: Diagnosis, free: Diagnosis) -> bool:
    """Whether an error remains with free parameters that may be the cause of what they explain."""
    explained = found.gap.after_m**2 - free.gap.after_m**2
    left = free.gap.after_m**2 - free.gap.noise_floor_m**2
    return free.verdict == "unexplained" and left > SMALL_SHARE * explained


def _held(found: Diagnosis) -> dict[str, dict[str, float]]:
    """Values of fixed parameters, and of those on a bound without effects, by their part."""
    blocks = found.model.blocks
    without_effects = dict(zip(found.model.parameters.names, found.calibrated_x.tolist(), strict=False))
    parts: dict[str, dict[str, float]] = {"target": _radii(found)} if found.dataset.radius_m else {}
    for name, item in blocks.given.items():
        if not item.given:  # it follows in closed form, and no file holds it
            continue
        near = TOUCH * (item.upper - item.lower)
        if name not in blocks.fixed and not item.lower + near < without_effects[name] < item.upper - near:
            parts.setdefault(_part(name, found.dataset), {})[name] = item.nominal
    return parts


def _radii(found: Diagnosis) -> dict[str, float]:
    """The stated radii of balls, by the names of the parameters if they were not stated."""
    names = (name.partition("@") for name in found.model.blocks.derived if name.startswith("ball."))
    balls = [(plain[:-1], session) for plain, *session in names if plain.endswith(".x")]
    return {f"{ball}radius{''.join(session)}": found.dataset.radius_m[ball[5:-1]] for ball, session in balls}


def _part(name: str, dataset: Dataset) -> str:
    owner, _, own = name.partition(".")
    if owner not in {*PARTS, *THINGS} and own:
        part = PARTS.get(own.partition(".")[0], "camera")
        return f"{owner}.{part}" if part in ("camera", "laser", "target") else part
    return PARTS.get(owner, "camera")


def _cause(part: str) -> str:
    """The class of causes of a part."""
    return {"hand_eye": "mount", "tool": "mount"}.get(part, part.rpartition(".")[2])


def _suspects(
    found: Diagnosis,
    held: Mapping[str, Mapping[str, float]],
    effects: Mapping[str, Sequence[tuple[CandidateEffect, ...]]],
    least: float,
    seed: int,
    off: ContradictedDistance | None = None,
) -> dict[str, Calibration]:
    """Calibrations in which one part's held parameters are free, beside some effects, that predict well enough.

    If they predict as well as effects of the same part, such as a decentred lens, these are the better name.

    Args:
        found: The diagnosis with these parameters as in the data set.
        held: Their values by part.
        effects: The parts to free, with the sets of effects that may then remain in the model.
        least: Least decrease of the mean squared error on new poses, in its standard errors.
        seed: Assigns poses to folds.
        off: A distance among the held parameters that the model with all effects found contradicts, whatever poses do.
    """
    before, suspects = squares(found.observed, found.after_m), {}
    for part, remaining in ((part, one) for part, sets in effects.items() for one in sets):
        freed = None if part in suspects else _freed(found, part, held[part], remaining, seed, off)
        if freed is None or freed.held_out is None:
            continue
        fall = fall_in_sigmas(before, squares(freed.fitted_model.dataset, freed.held_out))
        if found.unseen and freed.unseen:  # errors of the arm move whole poses, and may hide those of a lens
            within = squares_within(found.model, found.x, found.unseen.errors)
            freed_within = squares_within(freed.fitted_model, freed.x, freed.unseen.errors)
            fall = max(fall, fall_in_sigmas(within, freed_within))
        if fall > least or (off and off.key in held[part]):
            suspects[part] = freed
    return suspects


def _fewer(effects: Sequence[CandidateEffect]) -> list[tuple[CandidateEffect, ...]]:
    """None of some effects, and all but one."""
    return list(dict.fromkeys([(), *(tuple(one for one in effects if one != left) for left in effects)]))


def _freed(
    found: Diagnosis,
    part: str,
    names: Collection[str],
    effects: tuple[CandidateEffect, ...],
    seed: int,
    off: ContradictedDistance | None,
) -> Calibration | None:
    """The calibration with some parameters free, beside some effects; None if it fails."""
    plain = {name.partition("@")[0] for name in names}
    given = found.dataset.parameters
    kept = {name: item for name, item in given.items() if name not in plain}
    radius_m = {} if part == "target" else found.dataset.radius_m
    dataset = off.removed_from(found.dataset) if off and off.key in names else found.dataset
    for parameters in (kept, {name: item if name in kept else _widened(item) for name, item in given.items()}):
        try:  # without bounds those that have a closed form
            model = Model(replace(dataset, parameters=parameters, radius_m=radius_m), effects)
            return calibrated(model, Plan(weights="noise", seed=seed))
        except (RobolaserError, np.linalg.LinAlgError):
            continue
    return None


def _widened(item: Parameter) -> Parameter:
    """A parameter with bounds that no longer hold it: another lens, or other units, are up to four times as large."""
    least, most = sorted((item.nominal / MOST_WRONG, item.nominal * MOST_WRONG))
    room = item.upper - item.lower
    return replace(item, lower=min(least, item.lower - room), upper=max(most, item.upper + room))


def _reported(
    found: Diagnosis,
    free: Diagnosis,
    part: str,
    held: Mapping[str, float],
    would_be: Mapping[str, Estimate],
    probability: float,
) -> Diagnosis:
    """The diagnosis with free parameters, reported as one of the data set that holds them."""
    before, after = found.gap, free.gap
    gaps = before.calibrated_m, after.calibrated_m
    if gaps[1] >= gaps[0]:  # another cause is larger: the error falls only beside its effects
        gaps = before.after_m, after.after_m
    wrong = WrongInput(
        "held_parameter",
        part,
        _cause(part),
        probability,
        would_be,
        *gaps,
        () if probability >= CERTAIN else tuple(one for one in found.model.effects if one not in free.model.effects),
    )
    text = _sentence(wrong, held, _radii(found).keys())
    return with_fault(found, free, wrong, text, "parameters that the data set holds")


def _sentence(wrong: WrongInput, held: Mapping[str, float], radii: Set[str]) -> str:
    """A sentence on the held and the free values and their errors; radii and parameters have different tables."""
    numbers = list(wrong.parameters.items())[:NAMED]
    pairs = {name: _until_different(held[name], number.value) for name, number in numbers}
    are = listed([f"{name} at {pairs[name][0]} {number.unit}".rstrip() for name, number in numbers])
    would_be = listed([f"{pairs[name][1]} {number.unit}".rstrip() for name, number in numbers])
    they, them = ("they", "them") if len(numbers) > 1 else ("it", "it")
    rivals, be = members(wrong.alternatives), "are" if len(wrong.alternatives) > 1 else "is"
    distances = {name for name in held if name.endswith(DISTANCE)}
    files = {
        "[target], radius_m": radii & held.keys(),
        "[target], distances_m": distances,
        "[parameters]": held.keys() - radii - distances,
    }
    where = " and ".join(part for part, names in files.items() if names)
    after, before = millimetres(wrong.gap_after_m), millimetres(wrong.gap_before_m)
    error = f", and the error on new poses {after} instead of {before}" if after != before else ""
    todo = f"Measure {them} again, and correct" if distances == held.keys() else "Correct"
    return f"dataset.toml holds {are}; free, {they} would be {would_be}{error}. {todo} {them} under {where}." + (
        f" These poses do not show whether {rivals} {be} the cause instead." if rivals else ""
    )


def _until_different(one: float, other: float) -> tuple[str, str]:
    """Two numbers with four digits, or with as many as show two digits of their difference."""
    size, apart = max(abs(one), abs(other)), abs(one - other)
    digits = max(4, 2 + int(np.ceil(np.log10(size / apart)))) if apart > 0.0 else 4
    return f"{one:.{digits}g}", f"{other:.{digits}g}"


def _would_be(found: Diagnosis, name: str, off: ContradictedDistance | None) -> Estimate:
    """A parameter in the diagnosis in which it is free."""
    if off and off.key == name:
        return off.would_be(found.weighed.final)
    i = found.model.parameters.names.index(name)
    std = float(found.std[i])
    return Estimate(float(found.x[i]), std if np.isfinite(std) else None, found.model.parameters.items[i].unit)
