"""The verdict in a few sentences for the robot's users, certain statements first."""

from collections.abc import Mapping, Sequence

import numpy as np

from robolaser.calibration.exchanged_poses import exchanged
from robolaser.diagnosis.cause_classes import class_of, of_model, unknown_instead
from robolaser.diagnosis.cause_words import NAMED, listed, members, named, noun, site_phrase
from robolaser.diagnosis.localization import Localization
from robolaser.diagnosis.pose_scatter import BY_CHANCE, FLANGE, JOINTS, PartScatter
from robolaser.diagnosis.result import CauseClass, DetectionLimit, Finding, Gap, Repeatability, Validation
from robolaser.diagnosis.thresholds import LEAST_PROBABILITY, NO_DIFFERENCE
from robolaser.estimation.certainty import CERTAIN, EVEN


def sentence(
    verdict: str,
    findings: Sequence[Finding],
    classes: Sequence[CauseClass],
    where: Sequence[Localization],
    gap: Gap,
    repeatability: Repeatability,
    gross: str = "",
    scatter: PartScatter | None = None,
    hindrance: str = "",
) -> str:
    """The verdict in sentences.

    Args:
        verdict: `no_gap`, `explained` or `unexplained`.
        findings: Effects of the final model, most important first.
        classes: Classes of causes, most important first.
        where: Locations of the gap, the largest share first; for `unexplained`, of the remaining error.
        gap: The gap without and with effects.
        repeatability: Scatter of whole poses.
        gross: The sentence on gross errors.
        scatter: Excess scatter of whole poses, beyond noise.
        hindrance: Why no effect was searched for; empty otherwise.
    """
    if hindrance:
        text = f"{hindrance} On new poses {_compared_with_noise(gap)}" if gap.is_held_out else hindrance
    elif verdict == "no_gap":
        text = f"There is no gap: on new poses {_compared_with_noise(gap)}"
    elif verdict == "explained":
        text = _causes("The gap is explained", findings, classes, gap)
    else:
        text = _unexplained(findings, classes, where, gap)
    if (turns := gap.rotations) is not None:
        before, after, least = (
            f"{np.degrees(turn):.3g}°" for turn in (turns.calibrated_rad, turns.after_rad, turns.noise_floor_rad)
        )
        text += f" The error of rotations on new poses is {after}{f' ({before} without that)' if findings else ''}"
        text += f", where noise alone gives {least}."
    if findings and gap.distances_m is not None and gap.distances_m[1] <= EVEN * gap.distances_m[0]:
        before, after = map(millimetres, gap.distances_m)
        text += f" Known distances differ from the model by {after}; without that, by {before}."
    if scatter:
        text += f" {scatters(scatter)}"
    elif not hindrance and (where or verdict != "unexplained") and repeatability.is_most_of(gap.noise_floor_m):
        limit = "the stated repeatability" if repeatability.is_stated else "the usual repeatability of arms"
        text += (
            f" Whole poses scatter by {millimetres(repeatability.at_sensor_m)}, with no cause visible in these data."
            f" This is within {limit} and counts as noise."
        )
    return text + gross


def scatters(scatter: PartScatter) -> str:
    """State the excess scatter of whole poses, and what to check."""
    stated_m = scatter.stated_m
    limit = "is usual for arms" if stated_m is None else f"the stated repeatability of {millimetres(stated_m)}"
    if scatter.where == FLANGE:
        by = listed([_size(one.value, one.unit) for one in scatter.sizes.values() if one.value > one.limit])
        return (
            f"The flange scatters by {by} from pose to pose, more than {limit}: had the arm stopped, and is everything"
            " on the flange tight?"
        )
    which = "Joint readings scatter" if scatter.where == JOINTS else f"Readings of {scatter.where} scatter"
    (size,) = scatter.sizes.values()
    return (
        f"{which} by {_size(size.value, size.unit)}, more than {limit} ({_size(size.limit, size.unit)}): were they read"
        " before the arm had stopped? Are these commanded angles?"
    )


def _size(value: float, unit: str) -> str:
    return f"{np.degrees(value):.2g}°" if unit == "rad" else millimetres(value)


def imitated_sentence(limits: Sequence[DetectionLimit], classes: Sequence[CauseClass]) -> str:
    """State the causes of other classes that the effects found may imitate; may be empty."""
    named_classes = {one.name for one in classes}
    hidden = [one.candidate_effect for one in limits if one.is_imitated]
    hidden = [one for one in hidden if class_of(one) not in named_classes]
    if not hidden or not named_classes:
        return ""
    return (
        f" These data cannot distinguish {members(hidden)} from the effects found; other poses, or known distances,"
        " may."
    )


def exchanged_sentence(belongs: Mapping[int, int], names: Sequence[str]) -> str:
    """State which poses are exchanged, and their order in the diagnosis; may be empty. See `exchanged`."""
    if not belongs:
        return ""
    return f" {exchanged(belongs, names)}; this diagnosis uses them in the right order. Correct the data set."


def transfer_sentences(validation: Sequence[Validation], *, has_effects: bool) -> str:
    """State whether the findings, if there are any effects, transfer to other data of the same arm; may be empty."""
    return "".join(f" {transfer_sentence(one, has_effects=has_effects)}" for one in validation)


def transfer_sentence(validation: Validation, *, has_effects: bool) -> str:
    """State whether the findings transfer to another data set."""
    name, floor = validation.dataset, f"where noise alone gives {millimetres(validation.noise_floor_m)}"
    before, after = millimetres(validation.calibrated_m), millimetres(validation.after_m)
    if not has_effects:
        return f"On {name}, predicted with the same model, the error is {after}, {floor}."
    if validation.is_better:
        room = validation.calibrated_m**2 - validation.noise_floor_m**2
        closed = validation.calibrated_m**2 - validation.after_m**2
        carries = "It transfers" if closed >= EVEN * room else "Little of it transfers"
        return f"{carries} to {name}: there the error falls from {before} to {after}, {floor}."
    compared = f"the error there is {before} without the effects and {after} with them, {floor}"
    if validation.after_m < validation.calibrated_m:
        return f"Whether it transfers to {name} is not certain: {compared}."
    return f"It does not transfer to {name}: {compared}."


def millimetres(length_m: float) -> str:
    """A length with three digits; rounding errors are "less than 1 nm"."""
    return "less than 1 nm" if length_m < 1e-9 else f"{float(f'{1e3 * length_m:.3g}'):g} mm"


def _where_noise(gap: Gap) -> str:
    return f"where noise alone gives {millimetres(gap.noise_floor_m)}"


def _compared_with_noise(gap: Gap) -> str:
    if gap.after_ci95_m[1] < gap.noise_floor_m:
        return (
            f"the model's error is {millimetres(gap.after_m)}, less than the assumed noise"
            f" ({millimetres(gap.noise_floor_m)}). Noise that is assumed too large hides effects."
        )
    return _with_noise(gap)


def _with_noise(gap: Gap) -> str:
    return f"the model's error is {millimetres(gap.after_m)}; noise alone gives {millimetres(gap.noise_floor_m)}."


def _unexplained(
    findings: Sequence[Finding], classes: Sequence[CauseClass], where: Sequence[Localization], gap: Gap
) -> str:
    first = next((one for one in where if one.coordinate != BY_CHANCE), None)
    located = f" The remaining error is at {site_phrase(first.site)} ({first.coordinate})." if first else ""
    if findings:
        is_closed = gap.after_m <= NO_DIFFERENCE * gap.noise_floor_m
        imitated = _imitated(findings, classes, gap, located.replace("remaining ", "") if is_closed else located)
        return imitated or _causes("A part of the gap is explained", findings, classes, gap) + located
    if gap.rotations is None and gap.after_m <= NO_DIFFERENCE * gap.noise_floor_m:
        return (
            "The error on new poses is about that of noise alone, yet it is not random, and no effect of the"
            f" library explains it: {_with_noise(gap)}{located}"
        )
    return (
        f"The gap is real, and no effect of the library explains it: {millimetres(gap.after_m)} on new poses,"
        f" {_where_noise(gap)}.{located}"
    )


def _imitated(findings: Sequence[Finding], classes: Sequence[CauseClass], gap: Gap, located: str) -> str:
    """The unknown cause first, and the location of the rest, if the effects found only imitate it; else empty."""
    unknown = unknown_instead(classes)
    if not unknown or not findings:
        return ""
    at = "" if located or not unknown.site else f", at {site_phrase(unknown.site)},"
    how = "almost certainly" if unknown.probability >= CERTAIN else "probably"
    likeliest = _likeliest(of_model(classes))
    most = f"; the most probable of them is {likeliest}" if likeliest else ""
    return (
        f"The gap is real, but its cause{at} is {how} not an effect of the library.{located}"
        f" The effects found only imitate it{most}. {_shrinks(gap, 'them')}."
    )


def _likeliest(classes: Sequence[CauseClass]) -> str:
    """The most probable of some classes, with its probability; empty without classes."""
    likely = max(classes, key=lambda one: one.probability, default=None)
    return f"{noun(likely.name)} ({100 * likely.probability:.0f} %)" if likely else ""


def _causes(lead: str, findings: Sequence[Finding], classes: Sequence[CauseClass], gap: Gap) -> str:
    """The single effects if all are certain; else the certain classes, and the certain ones of their members."""
    certain = [found for found in findings if found.probability >= CERTAIN]
    doubtful = [found for found in findings if found.probability < CERTAIN]
    if not doubtful:
        return f"{lead}: {_clauses(certain)}. {_shrinks(gap)}."
    in_model = of_model(classes)
    sure = [one for one in in_model if one.probability >= CERTAIN]
    if not sure:
        likeliest = _likeliest(in_model)
        most = f"; most probable is {likeliest}" if likeliest else ""
        return f"{lead}, but no cause is certain{most}. {_shrinks(gap, 'all effects found')}."
    others = [
        one
        for one in (found.candidate_effect for found in findings)
        if class_of(one) not in {each.name for each in sure}
    ]
    which = f"that and {members(others)}" if others else "that"
    parts = [f"{lead} by {listed([_class(one, findings) for one in sure[:NAMED]])}.", f"{_shrinks(gap, which)}."]
    if len(in_model) > 1:
        losses = [f"{millimetres(one.gap_without_m or 0.0)} without {noun(one.name)}" for one in sure[:NAMED]]
        parts.append(f"It would be {listed(losses)}.")
    if certain:
        parts.append(f"Certain individually: {_clauses(certain)}.")
    return " ".join([*parts, _doubts(doubtful, sure, is_all=not certain)])


def _class(one: CauseClass, findings: Sequence[Finding]) -> str:
    """A class with its members in the model; those too improbable by themselves to be reported are counted."""
    probable = {candidate for candidate, _ in one.members}
    own = [found.candidate_effect for found in findings if class_of(found.candidate_effect) == one.name]
    reported = [candidate for candidate in own if candidate in probable]
    more = f", and {len(own) - len(reported)} more" if len(own) > len(reported) else ""
    return f"{noun(one.name)} ({members(reported)}{more})" if reported else noun(one.name)


def _doubts(doubtful: Sequence[Finding], sure: Sequence[CauseClass], *, is_all: bool) -> str:
    """Sentences on uncertain effects: sets that contain the cause, or that these poses do not show it."""
    open_ones = {found.candidate_effect for found in doubtful}
    sets = [each for one in sure for each in one.credible_sets if 1 < len(each) <= NAMED and open_ones & set(each)]
    distinct = {frozenset(each): each for each in sets}.values()
    either = [" or ".join(map(named, each)) for each in distinct]
    text = f"One of each is the cause: {'; '.join(either[:NAMED])}." if len(either) > 1 else ""
    if len(either) == 1:
        text = f"The cause is {either[0]}."
    if len(either) >= len(doubtful):
        return text
    which = "which of these single effects are the cause" if is_all and not text else "which others are the cause"
    reported = [found for found in doubtful if found.probability >= LEAST_PROBABILITY]
    if is_all and not text and len(reported) == 1:
        which = f"whether {named(reported[0].candidate_effect)} or another effect is the cause"
    return f"{text} These poses do not show {which}.".lstrip()


def _clauses(findings: Sequence[Finding]) -> str:
    clauses = [found.candidate_effect.clause for found in findings[:NAMED]]
    more = len(findings) - len(clauses)
    if more:
        clauses.append(f"{more} more {'effect was' if more == 1 else 'effects were'} found")
    return clauses[0] if len(clauses) == 1 else f"{', '.join(clauses[:-1])}, and {clauses[-1]}"


def _shrinks(gap: Gap, what: str = "that") -> str:
    floor = (
        f"less than the assumed noise ({millimetres(gap.noise_floor_m)})"
        if gap.after_ci95_m[1] < gap.noise_floor_m
        else _where_noise(gap)
    )
    before, after = millimetres(gap.calibrated_m), millimetres(gap.after_m)
    if gap.after_m >= gap.calibrated_m:
        return f"With {what} in the model the error on new poses is {after} ({before} without), {floor}"
    return f"With {what} in the model the error on new poses falls from {before} to {after}, {floor}"
