"""Parameters that the data set fixes, or narrowly bounds, at wrong values, and known distances that are wrong."""

from collections.abc import Callable, Mapping, Sequence

import numpy as np

from robolaser.calibration.calibrate import calibrated
from robolaser.calibration.plan import Plan
from robolaser.calibration.result import Calibration
from robolaser.data.dataset import Dataset
from robolaser.diagnosis.cause_classes import class_of
from robolaser.diagnosis.cause_words import NAMED, listed, members
from robolaser.diagnosis.held_values import Held, held_values
from robolaser.diagnosis.result import Diagnosis, Estimate, WrongInput
from robolaser.diagnosis.summary_text import millimetres
from robolaser.diagnosis.thresholds import SIGMA_OF_95_PERCENT, SMALL_SHARE
from robolaser.diagnosis.wrong_input import fall_in_sigmas, probability_of, squares, squares_within, with_fault
from robolaser.errors import RobolaserError
from robolaser.estimation.certainty import CERTAIN, EVEN, LIKELY
from robolaser.model.effects.effect import CandidateEffect
from robolaser.model.forward_model import Model

ROUGH = 0.01  # relative standard error from which a sentence gives it


def with_parameters_free(found: Diagnosis, examine: Callable[[Dataset], Diagnosis], seed: int) -> Diagnosis:
    """The diagnosis with one part's held parameters free, if that explains more, or as much as effects found.

    Args:
        found: The diagnosis with these parameters as in the data set: fixed, or on a bound.
        examine: Diagnoses another data set in the same way.
        seed: Assigns poses to folds.
    """
    if found.hindrance:
        return found
    groups = held_values(found)
    for suspected, least, most in ((_better, 0.0, 1.0), (_equivalent, EVEN, LIKELY)):
        suspects = [(held, freed) for held in groups if (freed := suspected(found, held, seed))]
        for held, freed in sorted(suspects, key=lambda one: one[1].held_out_rms_m or np.inf):
            free = examine(freed.model.dataset)
            would_be = held.moved(free)
            if not would_be or _may_imitate(found, free):
                continue
            probability = probability_of(found, free, held.log_odds)
            probability = min(max(probability, least), most)
            if round(probability, 2) >= EVEN:  # of equal ones, the fixed number: it costs no effect
                return _reported(found, free, held, would_be, probability)
    return found


def _better(found: Diagnosis, held: Held, seed: int) -> Calibration | None:
    """A calibration with free values that predicts certainly better beside effects of other parts.

    If these predict as well as effects of the same part, such as a decentred lens, they are the better name. A
    contradicted distance need not change a prediction.
    """
    others = tuple(one for one in found.model.effects if class_of(one) != held.cause)
    freed = _calibrated(held, others, seed)
    falls = freed and (held.off or max(_fall(found, freed), _fall_within(found, freed)) > SIGMA_OF_95_PERCENT)
    return freed if falls else None


def _equivalent(found: Diagnosis, held: Held, seed: int) -> Calibration | None:
    """A calibration with free values that predicts as well without the effects found, all of other parts, or one."""
    effects = found.model.effects
    if held.off or any(class_of(one) == held.cause for one in effects):
        return None
    for fewer in dict.fromkeys([(), *(tuple(one for one in effects if one != left) for left in effects)]):
        freed = _calibrated(held, fewer, seed) if len(fewer) < len(effects) else None
        if freed and _fall(found, freed) > -SIGMA_OF_95_PERCENT:
            return freed
    return None


def _calibrated(held: Held, effects: Sequence[CandidateEffect], seed: int) -> Calibration | None:
    """The calibration with free values beside some effects; None if it fails."""
    for dataset in held.freed:
        try:
            found = calibrated(Model(dataset, tuple(effects)), Plan(weights="noise", seed=seed))
        except (RobolaserError, np.linalg.LinAlgError):
            continue
        return None if found.held_out is None else found
    return None


def _fall(found: Diagnosis, freed: Calibration) -> float:
    """Decrease of the mean squared error on new poses, in its standard errors."""
    assert freed.held_out is not None  # `_calibrated` checks it
    return fall_in_sigmas(squares(found.observed, found.after_m), squares(freed.fitted_model.dataset, freed.held_out))


def _fall_within(found: Diagnosis, freed: Calibration) -> float:
    """The same beside motions of whole poses: errors of the arm, which move these, may hide those of a lens."""
    if not found.unseen or not freed.unseen:
        return -np.inf
    before = squares_within(found.model, found.x, found.unseen.errors)
    return fall_in_sigmas(before, squares_within(freed.fitted_model, freed.x, freed.unseen.errors))


def _may_imitate(found: Diagnosis, free: Diagnosis) -> bool:
    """Whether an error remains with free parameters that may be the cause of what they explain."""
    explained = found.gap.after_m**2 - free.gap.after_m**2
    left = free.gap.after_m**2 - free.gap.noise_floor_m**2
    return free.verdict == "unexplained" and left > SMALL_SHARE * explained


def _reported(
    found: Diagnosis, free: Diagnosis, held: Held, would_be: Mapping[str, Estimate], probability: float
) -> Diagnosis:
    """The diagnosis with free parameters, reported as one of the data set that holds them."""
    before, after = found.gap, free.gap
    gaps = before.calibrated_m, after.calibrated_m
    if gaps[1] >= gaps[0]:  # another cause is larger: the error falls only beside its effects
        gaps = before.after_m, after.after_m
    wrong = WrongInput(
        "held_parameter",
        held.where,
        held.cause,
        probability,
        would_be,
        *gaps,
        () if probability >= CERTAIN else tuple(one for one in found.model.effects if one not in free.model.effects),
    )
    return with_fault(found, free, wrong, _sentence(wrong, held), "parameters that the data set holds")


def _sentence(wrong: WrongInput, held: Held) -> str:
    """A sentence on the held and the free values and their errors."""
    numbers = list(wrong.parameters.items())[:NAMED]
    pairs = {name: _until_different(held.values[name], number.value) for name, number in numbers}
    names = {name: f"the {held.off}" if held.off else name for name, _ in numbers}
    are = listed([f"{names[name]} at {pairs[name][0]} {number.unit}".rstrip() for name, number in numbers])
    would_be = listed([f"{pairs[name][1]}{_roughly(number)} {number.unit}".rstrip() for name, number in numbers])
    they, them = ("they", "them") if len(numbers) > 1 else ("it", "it")
    rivals, be = members(wrong.alternatives), "are" if len(wrong.alternatives) > 1 else "is"
    after, before = millimetres(wrong.gap_after_m), millimetres(wrong.gap_before_m)
    error = f", and the error on new poses {after} instead of {before}" if after != before else ""
    todo = f"Measure {them} again, and correct" if held.off else "Correct"
    return f"dataset.toml holds {are}; free, {they} would be {would_be}{error}. {todo} {them} under {held.table}." + (
        f" These poses do not show whether {rivals} {be} the cause instead." if rivals else ""
    )


def _roughly(number: Estimate) -> str:
    """The standard error of a number, if it concerns the digits that are shown."""
    std = number.std or 0.0
    return f" ± {std:.1g}" if std > ROUGH * abs(number.value) else ""


def _until_different(one: float, other: float) -> tuple[str, str]:
    """Two numbers with four digits, or with as many as show two digits of their difference."""
    size, apart = max(abs(one), abs(other)), abs(one - other)
    digits = max(4, 2 + int(np.ceil(np.log10(size / apart)))) if apart > 0.0 else 4
    return f"{one:.{digits}g}", f"{other:.{digits}g}"
