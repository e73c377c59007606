"""How sure it is that an effect is the cause: what else could stand in its place."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import final

import numpy as np

from robolaser.diagnosis.fit import Fit
from robolaser.diagnosis.refits import Refits
from robolaser.diagnosis.thresholds import REFITTED_ALTERNATIVES, SHARE_OF_BEST_SCORE
from robolaser.diagnosis.verdict import credibility, is_alias, is_form, is_indistinguishable, posterior_weights
from robolaser.model.effects.effect import CandidateEffect


@final
@dataclass(frozen=True)
class EffectEvidence:
    """An effect of the final model against all that could stand in its place.

    Attributes:
        candidate_effect: The effect.
        explained: Chi-squared that only it explains.
        probability: Of it.
        credibility: Probability that it, and nothing unmodelled, explains what it does.
        weights: Probabilities of it and of each candidate that was tried in its place, None for neither; sum 1.
        without: The final model without it, fitted.
        alternatives: Indistinguishable candidates, the cheapest first, and the final model with each in its place.
    """

    candidate_effect: CandidateEffect
    explained: float
    probability: float
    credibility: float
    weights: Mapping[CandidateEffect | None, float]
    without: Fit
    alternatives: tuple[tuple[CandidateEffect, Fit], ...]


def evidence_for(
    refits: Refits, final: Fit, candidate_effect: CandidateEffect, unmodelled: float, unexplained: float
) -> EffectEvidence:
    """Weigh an effect of the final model.

    Args:
        refits: Fits other sets.
        final: The model.
        candidate_effect: The effect.
        unmodelled: Probability of an unmodelled cause in its place.
        unexplained: Chi-squared that no effect explains.
    """
    without = refits.refit(final, removed=candidate_effect)
    explained = without.chi2 - final.chi2
    tests = [test for test in refits.score_tests(without) if test.candidate_effect != candidate_effect]
    best = sorted(tests, key=lambda test: -test.gain)[:REFITTED_ALTERNATIVES]
    near = [test for test in best if test.gain > SHARE_OF_BEST_SCORE * explained]
    others = [(test.candidate_effect, refits.refit(without, [test])) for test in near]
    costs = np.array([refits.cost(fit) for fit in (final, *(fit for _, fit in others), without)])
    weights = posterior_weights(costs)
    believable = credibility(unmodelled, unexplained, explained)
    alike = [pair for pair in others if is_indistinguishable(final.deviance, pair[1].deviance)]
    return EffectEvidence(
        candidate_effect,
        explained,
        float(weights[0]) * believable,
        believable,
        dict(zip((candidate_effect, *(one for one, _ in others), None), weights.tolist(), strict=True)),
        without,
        tuple(sorted(alike, key=lambda pair: refits.cost(pair[1]))),
    )


def aliases(refits: Refits, final: Fit, evidence: Sequence[EffectEvidence]) -> list[CandidateEffect]:
    """Effects that only imitate what a larger one leaves, the least explaining first."""
    largest = max((one.explained for one in evidence), default=0.0)
    return [
        one.candidate_effect
        for one in sorted(evidence, key=lambda one: one.explained)
        if is_alias(one.explained, largest, len(_locations(one) - {one.candidate_effect.where}))
        or is_form(one.explained, _explained_beside(refits, final, one, evidence))
    ]


def _explained_beside(refits: Refits, final: Fit, one: EffectEvidence, evidence: Sequence[EffectEvidence]) -> float:
    """What an effect and larger ones at its place explain together; nothing where there are none."""
    larger = [other for other in evidence if other.explained > one.explained and _same_location(one, other)]
    if not larger:
        return 0.0
    without = one.without
    for other in larger:
        without = refits.refit(without, removed=other.candidate_effect)
    return without.chi2 - final.chi2


def _same_location(one: EffectEvidence, other: EffectEvidence) -> bool:
    return one.candidate_effect.where == other.candidate_effect.where


def _locations(one: EffectEvidence) -> set[str]:
    return {alternative.where for alternative, _ in one.alternatives}
