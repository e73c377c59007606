"""The verdict in a sentence or two, for a person who works with the robot."""

from collections.abc import Sequence

from robolaser.arrays import Ints
from robolaser.diagnosis.localization import Localization
from robolaser.diagnosis.repeatability import Repeatability
from robolaser.diagnosis.result import Finding, Gap, Validation
from robolaser.diagnosis.thresholds import EVEN
from robolaser.model.effects.effect import CandidateEffect

NAMED = 3
"""Effects that a sentence names; the rest are counted."""
WORTH_SAYING = 0.25
"""Scatter of whole poses over all noise, from which on it is said."""


def sentence(
    verdict: str,
    findings: Sequence[Finding],
    where: Sequence[Localization],
    gap: Gap,
    repeatability: Repeatability,
    gross: Ints,
) -> str:
    """Say the verdict.

    Args:
        verdict: `no_gap`, `explained` or `unexplained`.
        findings: Effects found, most important first.
        where: Places of the gap, the largest share first; for `unexplained`, of what is left.
        gap: How far the gap shrinks.
        repeatability: How much whole poses scatter.
        gross: Rows that are gross errors.
    """
    text = {"no_gap": _no_gap, "explained": _explained, "unexplained": _unexplained}[verdict](findings, where, gap)
    if repeatability.is_estimated and repeatability.at_sensor_m > WORTH_SAYING * gap.noise_floor_m:
        text += (
            f" Whole poses scatter by {millimetres(repeatability.at_sensor_m)} with no cause but chance: so well does"
            " the arm repeat, and that is a part of the noise."
        )
    if not len(gross):
        return text
    rows = (
        "One row of points.csv is a gross error"
        if len(gross) == 1
        else f"{len(gross)} rows of points.csv are gross errors"
    )
    return f"{text} {rows}, listed and left out."


def transfer_sentence(validation: Validation, *, has_effects: bool) -> str:
    """Say whether what was found holds for other data of the same arm.

    Args:
        validation: Errors there.
        has_effects: Whether anything was found.
    """
    name, floor = validation.dataset, f"where noise alone gives {millimetres(validation.noise_floor_m)}"
    before, after = millimetres(validation.calibrated_m), millimetres(validation.after_m)
    if not has_effects:
        return f"On {name}, predicted with the same model, the error is {after}, {floor}."
    if validation.is_better:
        return f"It carries over to {name}: there the error falls from {before} to {after}, {floor}."
    compared = f"the error there is {before} without the effects and {after} with them, {floor}"
    if validation.after_m < validation.calibrated_m:
        return f"Whether it carries over to {name} is not certain: {compared}."
    return f"It does not carry over to {name}: {compared}."


def millimetres(length_m: float) -> str:
    """A length with the digits that an error has."""
    return f"{1e3 * length_m:.3g} mm"


def _no_gap(findings: Sequence[Finding], where: Sequence[Localization], gap: Gap) -> str:
    return (
        f"There is no gap: on new poses the model errs by {millimetres(gap.after_m)},"
        f" and noise alone gives {millimetres(gap.noise_floor_m)}."
    )


def _explained(findings: Sequence[Finding], where: Sequence[Localization], gap: Gap) -> str:
    return f"The gap is explained: {_causes(findings)}. {_shrinks(gap)}.{_aliases(findings)}"


def _unexplained(findings: Sequence[Finding], where: Sequence[Localization], gap: Gap) -> str:
    lies = f" What is left lies at {where[0].site} ({where[0].coordinate})." if where else ""
    if not findings:
        return (
            f"The gap is real, and no effect of the library explains it: {millimetres(gap.after_m)} on new poses,"
            f" where noise alone gives {millimetres(gap.noise_floor_m)}.{lies}"
        )
    return f"A part of the gap is explained: {_causes(findings)}. {_shrinks(gap)}.{lies}{_aliases(findings)}"


def _shrinks(gap: Gap) -> str:
    return (
        f"With that in the model the error on new poses falls from {millimetres(gap.calibrated_m)}"
        f" to {millimetres(gap.after_m)}, where noise alone gives {millimetres(gap.noise_floor_m)}"
    )


def _causes(findings: Sequence[Finding]) -> str:
    clauses = [_perhaps(found) + found.candidate_effect.clause for found in findings[:NAMED]]
    more = len(findings) - len(clauses)
    if more:
        clauses.append(f"{more} more {'effect was' if more == 1 else 'effects were'} found")
    return clauses[0] if len(clauses) == 1 else f"{', '.join(clauses[:-1])}, and {clauses[-1]}"


def _perhaps(found: Finding) -> str:
    return "" if found.probability >= EVEN else "perhaps "


def _aliases(findings: Sequence[Finding]) -> str:
    """What could as well be the cause; may be empty."""
    ambiguous = [found for found in findings if found.alternatives]
    pairs = [
        f"{_at(found.candidate_effect)} from {_one_of([other.candidate_effect for other in found.alternatives])}"
        for found in ambiguous[:NAMED]
    ]
    more = len(ambiguous) - len(pairs)
    others = f", nor {more} more from theirs" if more else ""
    return f" These poses do not tell {', nor '.join(pairs)}{others}." if pairs else ""


def _one_of(alternatives: Sequence[CandidateEffect]) -> str:
    return _at(alternatives[0]) + (f" and {len(alternatives) - 1} more" if len(alternatives) > 1 else "")


def _at(candidate_effect: CandidateEffect) -> str:
    return str(candidate_effect)
