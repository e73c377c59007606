"""The evidence for an effect against the alternatives that could replace it."""

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from typing import final

import numpy as np

from robolaser.diagnosis.arm_geometry import placements_of_arm
from robolaser.diagnosis.fit import Fit
from robolaser.diagnosis.held_out_gap import HeldOut
from robolaser.diagnosis.penalties import credibility, posterior_weights
from robolaser.diagnosis.refits import Refits
from robolaser.diagnosis.thresholds import (
    CHI2_PER_EFFECT,
    LEAST_PROBABILITY,
    NO_DIFFERENCE,
    SEARCH_LIMIT,
    SHARE_OF_BEST_SCORE,
)
from robolaser.diagnosis.zeros_or_placement import set_rivals
from robolaser.estimation.certainty import LIKELY
from robolaser.model.effects.effect import CandidateEffect


@final
@dataclass(frozen=True)
class EffectEvidence:
    """An effect of the final model against all alternatives."""

    candidate_effect: CandidateEffect
    explained: float  # increase of chi-squared without the effect
    probability: float
    credibility: float  # probability that the effect, not an unmodelled cause, explains this; 1 before `doubted`
    # probabilities of the effect, of each candidate tried instead, and, under None, of neither; their sum is 1,
    # except for candidates that occur together
    weights: Mapping[CandidateEffect | None, float]
    fits: Mapping[CandidateEffect | None, Fit]  # the model for each of these probabilities
    alternatives: tuple[tuple[CandidateEffect, Fit], ...]  # indistinguishable, the cheapest first; each one's model

    @property
    def without(self) -> Fit:
        """The refitted model without the effect."""
        return self.fits[None]

    def doubted(self, unmodelled: float, unexplained: float) -> "EffectEvidence":
        """The same with the probability of an unmodelled cause, and the chi-squared that no effect explains."""
        believable = credibility(unmodelled, unexplained, self.explained)
        return replace(self, probability=self.probability * believable, credibility=believable)


def evidence_for(refits: Refits, final: Fit, candidate_effect: CandidateEffect, held_out: HeldOut) -> EffectEvidence:
    """Weigh an effect of the final model against its alternatives."""
    without = refits.refit(final, removed=candidate_effect)
    explained = without.chi2 - final.chi2
    others = dict(_alternatives_refitted(refits, final, candidate_effect))
    these: dict[CandidateEffect | None, Fit] = {candidate_effect: final, None: without}
    fits = these | others
    models = tuple(dict.fromkeys(fits.values()))
    weights = dict(zip(models, posterior_weights(np.array(list(map(refits.cost, models)))).tolist(), strict=True))
    by_candidate = {one: weights[fit] for one, fit in fits.items()}
    near = [pair for pair in others.items() if pair[1].deviance - final.deviance < CHI2_PER_EFFECT]
    indistinguishable = sorted(near, key=lambda pair: refits.cost(pair[1]))
    by_candidate |= _of_plausible_sizes(by_candidate, fits, [candidate_effect, *dict(indistinguishable)], held_out)
    for rival in set_rivals(refits, final, candidate_effect, held_out):
        instead = by_candidate[candidate_effect] * rival.probability
        by_candidate[candidate_effect] -= instead
        by_candidate |= {one: max(instead, by_candidate.get(one, 0.0)) for one in rival.effects}
        fits |= dict.fromkeys(rival.effects, rival.fit)
        if rival.probability > LEAST_PROBABILITY:
            indistinguishable = [*((one, rival.fit) for one in rival.effects), *indistinguishable]
    return EffectEvidence(
        candidate_effect,
        explained,
        by_candidate[candidate_effect],
        1.0,
        by_candidate,
        fits,
        tuple({one: (one, fit) for one, fit in reversed(indistinguishable)}.values())[::-1],
    )


def _of_plausible_sizes(
    weights: Mapping[CandidateEffect | None, float],
    fits: Mapping[CandidateEffect | None, Fit],
    rivals: Sequence[CandidateEffect],
    held_out: HeldOut,
) -> dict[CandidateEffect | None, float]:
    """Changed weights of indistinguishable rivals of which an effect of an implausible size has the largest.

    A tracker's scale that is off by a per cent costs less than one more link of a wrong length, but is less likely.
    Nothing changes if it predicts new poses better: further parameters alone make a prediction a little worse.
    """
    best = max(rivals, key=lambda one: weights[one])
    plausible = [one for one in rivals if fits[one].is_plausible(one)]
    if best in plausible or not plausible:
        return {}
    instead = max(plausible, key=lambda one: weights[one])
    if held_out.misfit(fits[instead]) > NO_DIFFERENCE * held_out.misfit(fits[best]):
        return {}
    others = [one for one in rivals if one not in plausible]
    had = sum(weights[one] for one in others)
    left = min(1.0, (1.0 - LIKELY) / had)
    changed: dict[CandidateEffect | None, float] = {one: left * weights[one] for one in others}
    return changed | {instead: weights[instead] + (1.0 - left) * had}


def _alternatives_refitted(
    refits: Refits, final: Fit, candidate_effect: CandidateEffect
) -> Iterator[tuple[CandidateEffect, Fit]]:
    """Candidates with a score near that of an effect of the final model, and that model with each instead.

    One may make another effect unnecessary, too. Candidates beyond their bounds there are omitted.
    """
    without = refits.refit(final, removed=candidate_effect)
    tests = [test for test in refits.score_tests(without) if test.candidate_effect != candidate_effect]
    best = sorted(tests, key=lambda test: -test.gain)[:SEARCH_LIMIT]
    near = [test for test in best if test.gain > SHARE_OF_BEST_SCORE * (without.chi2 - final.chi2)]
    refitted = ((test.candidate_effect, refits.refit(without, [test])) for test in near)
    needed = ((one, _with_all_needed(refits, fit, one)) for one, fit in refitted)
    return ((one, fit) for one, fit in needed if not fit.exceeds_bounds(one))


def _with_all_needed(refits: Refits, fit: Fit, new: CandidateEffect) -> Fit:
    """The cheapest of a fit and those without one of the effects that the new one may make unnecessary."""
    kept = (new, *placements_of_arm(fit.effects))
    others = [test for test in refits.tests_of(fit) if test.candidate_effect not in kept]
    unneeded = (test.candidate_effect for test in others if fit.wald(test.candidate_effect) < test.penalty)
    return min([fit, *(refits.refit(fit, removed=one) for one in unneeded)], key=refits.cost)
