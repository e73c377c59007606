"""Classes of causes: often certain although their members are indistinguishable.

In an arm with small errors everywhere a dozen effects can replace one another, but nothing outside the arm's geometry
can replace all of them.
"""

from collections.abc import Callable, Mapping, Sequence
from dataclasses import replace
from typing import Final

import numpy as np

from robolaser.diagnosis.evidence import EffectEvidence
from robolaser.diagnosis.fit import Fit
from robolaser.diagnosis.held_out_gap import HeldOut
from robolaser.diagnosis.local_unknown import has_form
from robolaser.diagnosis.localization import Localization
from robolaser.diagnosis.penalties import posterior_weights
from robolaser.diagnosis.pose_scatter import CLASS as SCATTER
from robolaser.diagnosis.pose_scatter import PartScatter
from robolaser.diagnosis.refits import PostureRivals, Refits
from robolaser.diagnosis.result import CauseClass, CauseKind
from robolaser.diagnosis.thresholds import CHI2_OF_UNMODELLED_CAUSE, CREDIBLE_MASS, LEAST_PROBABILITY
from robolaser.estimation.certainty import EVEN
from robolaser.model.effects.effect import CandidateEffect

UNKNOWN: Final = "unknown"  # the class of causes outside the library of effects


def class_of(candidate_effect: CandidateEffect) -> str:
    """The class that an effect declares, or its name."""
    return candidate_effect.effect.cause or candidate_effect.effect.name


def cause_classes(
    verdict: str,
    refits: Refits,
    final: Fit,
    evidence: Sequence[EffectEvidence],
    left: Sequence[Localization],
    held_out: HeldOut,
    scatter: PartScatter | None = None,
) -> tuple[CauseClass, ...]:
    """Every class that may be present: probable ones first, by their part of the gap, then the others by probability.

    Args:
        verdict: An `explained` gap has an unknown cause only if no class is likely, an `unexplained` one may have it
            also beside likely classes; without a gap there is none.
        refits: Fits sets of effects.
        final: The final model.
        evidence: For each of its effects.
        left: Locations of its remaining error.
        held_out: Errors on held-out poses.
        scatter: Excess scatter of whole poses, beyond noise.
    """
    if verdict == "no_gap":
        return ()
    gap = held_out.gap(final)
    probabilities = member_probabilities(evidence)
    found: list[CauseClass] = []
    for name in dict.fromkeys(map(class_of, probabilities)):
        members = {one: p for one, p in probabilities.items() if class_of(one) == name}
        own = [one for one in evidence if class_of(one.candidate_effect) == name]
        probability = at_least_one(list(members.values()))
        without_m = None
        if own:
            without = refits.without(final, [one.candidate_effect for one in own])
            without_m = held_out.gap_without(refits.of(without))
            probability = max(probability, _probability(refits, final, without, own, class_of, name))
        if probability < LEAST_PROBABILITY:
            continue
        found.append(CauseClass(name, probability, without_m, gap, _ordered(members), _credible_sets(own)))
    if scatter:
        found.append(CauseClass(SCATTER, scatter.share * (1.0 - scatter.p_value), None, gap, site=scatter.where))
    remaining = next((site for site in left if site.unknown), None)
    if remaining and verdict == "unexplained":
        odds = posterior_weights(np.array([0.0, remaining.likelihood_ratio - CHI2_OF_UNMODELLED_CAUSE]))
        probability = float(odds[0]) * departs(remaining.site, evidence)
        found.append(CauseClass(UNKNOWN, probability, None, gap))
    elif _likeliest(found) < EVEN and (evidence if verdict == "explained" else refits.effects and not scatter):
        # effects that close the gap without a likely class only imitate its cause
        found.append(CauseClass(UNKNOWN, 1.0 - _likeliest(found), None, gap))
    return tuple(sorted(found, key=_importance))


def cause_kinds(
    refits: Refits, final: Fit, evidence: Sequence[EffectEvidence], held_out: HeldOut
) -> tuple[CauseKind, ...]:
    """Every effect of the final model, with all of its locations: it can be certain although no location is.

    As with classes, those too improbable to be reported are omitted.
    """
    probabilities = member_probabilities(evidence)
    found: list[CauseKind] = []
    for kind in dict.fromkeys(one.candidate_effect.effect for one in evidence):
        own = [one for one in evidence if one.candidate_effect.effect is kind]
        locations = {one.where: p for one, p in probabilities.items() if one.effect is kind}
        without = refits.without(final, [one.candidate_effect for one in own])
        probability = at_least_one(list(locations.values()))
        if probability < CREDIBLE_MASS and len(locations) > 1:
            probability = max(probability, _probability(refits, final, without, own, lambda one: one.effect, kind))
        if probability < LEAST_PROBABILITY:
            continue
        where = tuple(dict.fromkeys(one.candidate_effect.where for one in own))
        found.append(CauseKind(kind.name, where, probability, held_out.gap_without(refits.of(without))))
    return tuple(sorted(found, key=lambda one: (one.probability < EVEN, -one.gap_without_m)))


def reweighed_classes(
    classes: Sequence[CauseClass], before: Sequence[EffectEvidence], now: Sequence[EffectEvidence]
) -> tuple[CauseClass, ...]:
    """The reported classes with new evidence for their members; everything else in their probabilities is unchanged."""
    were, are = member_probabilities(before), member_probabilities(now)
    updated = []
    for one in classes:
        members = {each: p for each, p in are.items() if class_of(each) == one.name}
        probability = _reweighed(
            one.probability, [p for each, p in were.items() if class_of(each) == one.name], list(members.values())
        )
        own = [each for each in now if class_of(each.candidate_effect) == one.name]
        changed = replace(one, probability=probability, members=_ordered(members), credible_sets=_credible_sets(own))
        updated.append(changed if members else one)
    return tuple(sorted(updated, key=_importance))


def reweighed_kinds(
    kinds: Sequence[CauseKind], before: Sequence[EffectEvidence], now: Sequence[EffectEvidence]
) -> tuple[CauseKind, ...]:
    """The kinds with new evidence, see `reweighed_classes`."""
    were, are = (
        {one: [p for each, p in found.items() if each.effect.name == one.effect] for one in kinds}
        for found in (member_probabilities(before), member_probabilities(now))
    )
    return tuple(replace(one, probability=_reweighed(one.probability, were[one], are[one])) for one in kinds)


def _reweighed(stated: float, before: Sequence[float], now: Sequence[float]) -> float:
    """The probability of any member, if the stated one was computed from the members; else the stated one."""
    return at_least_one(now) if np.isclose(stated, at_least_one(before), rtol=0.0) else stated


def at_least_one(probabilities: Sequence[float]) -> float:
    """Probability of at least one of several independent causes."""
    return 1.0 - float(np.prod([1.0 - p for p in probabilities]))


def departs(site: str, evidence: Sequence[EffectEvidence]) -> float:
    """Probability that the remaining error at a site is more than an inexact form of an effect found there.

    A second cause at one location is far less likely: the effect and the unknown share one probability.
    """
    return 1.0 - max((one.credibility for one in evidence if one.candidate_effect.where == site), default=0.0)


def unknown_at(classes: Sequence[CauseClass], where: Sequence[Localization]) -> tuple[CauseClass, ...]:
    """The classes, the unknown with the site of the largest remaining share; without a site if none is known."""
    site = where[0].site if where else ""
    return tuple(replace(one, site=site) if one.name == UNKNOWN else one for one in classes)


def _likeliest(classes: Sequence[CauseClass]) -> float:
    return max((one.probability for one in classes), default=0.0)


def unknown_instead(classes: Sequence[CauseClass]) -> CauseClass | None:
    """The unknown if it is likely and no class of the effects in the model is: those only imitate it."""
    if any(one.probability >= EVEN for one in of_model(classes)):
        return None
    return next((one for one in classes if one.name == UNKNOWN and one.probability >= EVEN), None)


def of_model(classes: Sequence[CauseClass]) -> list[CauseClass]:
    """Classes of effects in the model."""
    return [one for one in classes if one.gap_without_m is not None]


def _importance(one: CauseClass) -> tuple[bool, float, float]:
    """Sort key: probable classes first, those with the largest part of the gap before the others."""
    doubtful = one.probability < EVEN
    return doubtful, -(one.gap_without_m or 0.0) * (not doubtful), -one.probability


def member_probabilities(evidence: Sequence[EffectEvidence]) -> dict[CandidateEffect, float]:
    """Probability of each candidate to be a cause, if each found effect has one, by its alternatives' weights."""
    none: dict[CandidateEffect, float] = {}
    for one in evidence:
        for candidate, weight in one.weights.items():
            if candidate is not None:
                none[candidate] = none.get(candidate, 1.0) * (1.0 - weight * one.credibility)
    return {candidate: 1.0 - p for candidate, p in none.items() if 1.0 - p >= LEAST_PROBABILITY}


def _ordered(members: Mapping[CandidateEffect, float]) -> tuple[tuple[CandidateEffect, float], ...]:
    return tuple(sorted(members.items(), key=lambda pair: -pair[1]))


def _credible_sets(evidence: Sequence[EffectEvidence]) -> tuple[tuple[CandidateEffect, ...], ...]:
    return tuple(filter(None, map(credible_set, evidence)))


def credible_set(evidence: EffectEvidence) -> tuple[CandidateEffect, ...]:
    """The smallest set of candidates for an effect with the credible mass; rivals that occur together stay together.

    Empty if the mass includes the case of no effect, or an unmodelled cause.
    """
    chosen: list[CandidateEffect] = []
    mass = last = 0.0
    for candidate, weight in sorted(evidence.weights.items(), key=lambda pair: -pair[1]):
        if mass >= CREDIBLE_MASS and weight < last:
            return tuple(chosen)
        if candidate is None:
            return ()
        chosen.append(candidate)
        mass, last = mass + weight * evidence.credibility, weight
    return tuple(chosen) if mass >= CREDIBLE_MASS else ()


def _probability(
    refits: Refits,
    final: Fit,
    without: Fit,
    evidence: Sequence[EffectEvidence],
    of: Callable[[CandidateEffect], object],
    name: object,
) -> float:
    """Probability of a group of effects against none of them, or an unmodelled cause.

    The remaining error does not count: another cause may be present, too. An unmodelled cause may be a function of one
    joint if all effects of the group are there. It is no larger than the effects' alternatives outside the group allow.
    """
    costs = np.array([refits.cost(fit) for fit in (final, without)])
    others = min(max((w for c, w in one.weights.items() if c and of(c) != name), default=0.0) for one in evidence)
    own = [one.candidate_effect for one in evidence]
    unmodelled = [refits.unmodelled(final, without), PostureRivals.of(refits, final).unmodelled(own)]
    if len({one.where for one in own}) == 1 and has_form(final, own[0]):
        unmodelled.append(min(refits.locally_unmodelled(final, one) for one in own))
    return min(1.0 - others, float(posterior_weights(costs)[0]) * (1.0 - max(unmodelled)))
