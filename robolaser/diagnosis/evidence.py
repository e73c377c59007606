"""How certain an effect is: what could replace it."""

from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from typing import final

import numpy as np

from robolaser.diagnosis.fit import Fit
from robolaser.diagnosis.held_out_gap import HeldOut
from robolaser.diagnosis.refits import Refits
from robolaser.diagnosis.thresholds import (
    LEAST_PROBABILITY,
    MAX_ALTERNATIVES,
    SHARE_OF_BEST_SCORE,
)
from robolaser.diagnosis.verdict import credibility, is_indistinguishable, posterior_weights
from robolaser.diagnosis.zeros_or_placement import set_rivals
from robolaser.model.effects.effect import CandidateEffect


@final
@dataclass(frozen=True)
class EffectEvidence:
    """An effect of the final model against everything that could replace it.

    Attributes:
        candidate_effect: The effect.
        explained: Chi-squared that only it explains.
        probability: Of it.
        credibility: Probability that it, and nothing unmodelled, explains what it does.
        weights: Probabilities of it and of each candidate that was tried in its place, None for neither; sum 1, but for
            those that are at work together.
        fits: The model that each of these is a probability of.
        alternatives: Indistinguishable candidates, the cheapest first, and the final model with each in its place.
    """

    candidate_effect: CandidateEffect
    explained: float
    probability: float
    credibility: float
    weights: Mapping[CandidateEffect | None, float]
    fits: Mapping[CandidateEffect | None, Fit]
    alternatives: tuple[tuple[CandidateEffect, Fit], ...]

    @property
    def without(self) -> Fit:
        """The final model without it, fitted."""
        return self.fits[None]


def evidence_for(
    refits: Refits,
    final: Fit,
    candidate_effect: CandidateEffect,
    unmodelled: float,
    unexplained: float,
    held_out: HeldOut,
) -> EffectEvidence:
    """Weigh an effect of the final model.

    Args:
        refits: Fits other sets.
        final: The model.
        candidate_effect: The effect.
        unmodelled: Probability of an unmodelled cause in its place.
        unexplained: Chi-squared that no effect explains.
        held_out: Errors on held-out poses.
    """
    without = refits.refit(final, removed=candidate_effect)
    explained = without.chi2 - final.chi2
    others = list(_alternatives_refitted(refits, final, candidate_effect))
    costs = np.array([refits.cost(fit) for fit in (final, *(fit for _, fit in others), without)])
    weights = posterior_weights(costs)
    believable = credibility(unmodelled, unexplained, explained)
    by_candidate: dict[CandidateEffect | None, float] = dict(
        zip((candidate_effect, *(one for one, _ in others), None), weights.tolist(), strict=True)
    )
    fits: dict[CandidateEffect | None, Fit] = {candidate_effect: final, None: without, **dict(others)}
    alike = [pair for pair in others if is_indistinguishable(final.deviance, pair[1].deviance)]
    alike = sorted(alike, key=lambda pair: refits.cost(pair[1]))
    for rival in set_rivals(refits, final, candidate_effect, held_out):
        instead = by_candidate[candidate_effect] * rival.probability
        by_candidate[candidate_effect] -= instead
        by_candidate |= {one: max(instead, by_candidate.get(one, 0.0)) for one in rival.effects}
        fits |= dict.fromkeys(rival.effects, rival.fit)
        if rival.probability > LEAST_PROBABILITY:
            alike = [*((one, rival.fit) for one in rival.effects), *alike]
    return EffectEvidence(
        candidate_effect,
        explained,
        by_candidate[candidate_effect] * believable,
        believable,
        by_candidate,
        fits,
        tuple({one: (one, fit) for one, fit in reversed(alike)}.values())[::-1],
    )


def _alternatives_refitted(
    refits: Refits, final: Fit, candidate_effect: CandidateEffect
) -> Iterator[tuple[CandidateEffect, Fit]]:
    """Candidates that promise as much as an effect of the final model, and that model with each in its place.

    None of them is larger than plausible there.
    """
    without = refits.refit(final, removed=candidate_effect)
    tests = [test for test in refits.score_tests(without) if test.candidate_effect != candidate_effect]
    best = sorted(tests, key=lambda test: -test.gain)[:MAX_ALTERNATIVES]
    near = [test for test in best if test.gain > SHARE_OF_BEST_SCORE * (without.chi2 - final.chi2)]
    refitted = ((test.candidate_effect, refits.refit(without, [test])) for test in near)
    return ((one, fit) for one, fit in refitted if not fit.exceeds_bounds(one))
