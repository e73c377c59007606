"""Pruning of the final model: effects must improve the prediction of new poses and be likelier than unmodelled causes.

The remaining effects are listed, exported, counted in classes and used in predictions.
"""

from collections.abc import Mapping, Sequence
from functools import cache
from itertools import pairwise

from robolaser.diagnosis.evidence import EffectEvidence, evidence_for
from robolaser.diagnosis.fit import Fit
from robolaser.diagnosis.held_out_gap import HeldOut
from robolaser.diagnosis.local_unknown import has_form
from robolaser.diagnosis.localization import Localization, localize
from robolaser.diagnosis.penalties import credibility
from robolaser.diagnosis.refits import Announce, PostureRivals, Refits
from robolaser.diagnosis.thresholds import LEAST_PROBABILITY
from robolaser.estimation.certainty import CERTAIN, EVEN
from robolaser.model.effects.effect import CandidateEffect


def prune(
    refits: Refits, final: Fit, held_out: HeldOut, progress: Announce = lambda what: None
) -> tuple[list[Fit], list[EffectEvidence], list[Localization]]:
    """Remove effects until there is enough evidence for each remaining one.

    The order of removal is: effects beyond their bounds; effects without which held-out poses are predicted as well;
    effects less likely than an unmodelled cause; effects that are not credible; effects that do not lower the held-out
    error when they are added. Of several, the worse half is removed at a time. After removals an alternative may be
    more probable than an effect, and then replaces it. The effects that explain least are weighed first: they are the
    likeliest to be replaced, after which all are weighed again; only when all remain, without optics, are they weighed
    against unmodelled causes.

    Returns:
        Fits of the remaining effects, added one by one to the model without any; the evidence for each of them; and the
        locations of the last fit's remaining error.
    """
    located, rivals = cache(localize), cache(lambda fit: PostureRivals.of(refits, fit))

    def unexplained(fit: Fit) -> float:
        return sum(one.likelihood_ratio for one in located(fit))

    @cache
    def instead_of(fit: Fit, one: CandidateEffect) -> float:
        progress(f"weighing {one} against unmodelled causes")
        return max(_unmodelled(refits, fit, one), rivals(fit).unmodelled([one]))

    final = _helpful(refits, final, held_out, progress)
    visited = {frozenset(final.effects)}  # sets so far: a replacement may undo an earlier one
    while True:
        if (plausible := _plausible(refits, final)) is not final:
            final = _helpful(refits, plausible, held_out, progress)
            continue
        # without optics the geometry of a whole arm counts, and none of its parts is removed for explaining little
        unmodelled = {one: instead_of(final, one) for one in final.effects if final.has_optics}
        doubtful = sorted((one for one in unmodelled if unmodelled[one] > EVEN), key=lambda one: -unmodelled[one])
        if unmodelled and not doubtful:
            doubtful = _incredible(refits, final, unmodelled, unexplained(final))
        if doubtful:
            final = _without_half(refits, final, doubtful)
            continue
        helpful = _helpful(refits, final, held_out, progress)
        if helpful is not final:
            final = helpful
            continue
        evidence: dict[CandidateEffect, EffectEvidence] = {}
        for one in sorted(final.effects, key=lambda one: refits.refit(final, removed=one).chi2):
            progress(f"weighing {one} against other effects")
            evidence[one] = evidence_for(refits, final, one, held_out)
            better = exchanged(final, evidence[one], held_out)
            if better is not None and frozenset(better.effects) not in visited:
                final = better
                visited.add(frozenset(final.effects))
                break
        else:
            found = [evidence[one].doubted(instead_of(final, one), unexplained(final)) for one in final.effects]
            nested = nested_fits(refits, refits.of(final), held_out, found)
            if doubtful := _not_lowering(nested, held_out):
                final = _without_half(refits, nested[-1], doubtful)
                continue
            return nested, found, located(final)


def nested_fits(refits: Refits, final: Fit, held_out: HeldOut, evidence: Sequence[EffectEvidence] = ()) -> list[Fit]:
    """Fits from the start to the final model, adding the effect with the largest gap without it first.

    An effect that does not lower the gap is postponed: many do so only beside others. Effects too improbable to be
    listed are last.
    """
    gaps = {one: held_out.misfit(refits.refit(final, removed=one)) for one in final.effects}
    folded = {one.candidate_effect for one in evidence if one.probability < LEAST_PROBABILITY}
    remaining = sorted(
        refits.tests_of(final), key=lambda test: (test.candidate_effect in folded, -gaps[test.candidate_effect])
    )
    fits, waiting = [refits.start], 0
    while remaining:
        test = remaining.pop(0)
        fit = refits.of(fits[-1], [test]) if remaining else final
        if waiting < len(remaining) and held_out.misfit(fit) >= held_out.misfit(fits[-1]):
            remaining.append(test)
            waiting += 1
        else:
            fits.append(fit)
            waiting = 0
    return fits


def _not_lowering(nested: Sequence[Fit], held_out: HeldOut) -> list[CandidateEffect]:
    """Effects that do not lower the held-out error when they are added, the largest increase first."""
    rises = {}
    for before, after in pairwise(nested):
        (added,) = set(after.effects) - set(before.effects)
        rises[added] = held_out.misfit(after) - held_out.misfit(before)
    return sorted((one for one in rises if rises[one] >= 0.0), key=lambda one: -rises[one])


def _without_half(refits: Refits, final: Fit, doubtful: Sequence[CandidateEffect]) -> Fit:
    """Remove the first half of some effects."""
    return refits.without(final, doubtful[: -(-len(doubtful) // 2)])


def _plausible(refits: Refits, final: Fit) -> Fit:
    """Remove effects that the data push beyond their bounds, one by one, the one that explains least first."""
    while beyond := [one for one in final.effects if final.exceeds_bounds(one)]:
        final = min((refits.refit(final, removed=one) for one in beyond), key=lambda fit: fit.chi2)
    return final


def exchanged(final: Fit, evidence: EffectEvidence, held_out: HeldOut) -> Fit | None:
    """The fit with an effect replaced by a likely alternative that predicts new poses at least as well; else None.

    One of an implausible size is replaced by any likely alternative.
    """
    probable = (fit for other, fit in evidence.alternatives if evidence.weights[other] > EVEN)
    is_plausible = final.is_plausible(evidence.candidate_effect)
    return next((fit for fit in probable if not is_plausible or held_out.misfit(fit) <= held_out.misfit(final)), None)


def _unmodelled(refits: Refits, final: Fit, candidate_effect: CandidateEffect) -> float:
    """Probability of an unmodelled cause instead of an effect, or of all effects at its location.

    At a joint it may be a function of that joint alone, instead of effects with a form, or beside them.
    """
    where = candidate_effect.where
    without = refits.refit(final, removed=candidate_effect)
    probabilities = [refits.unmodelled(final, without)]
    if beside := [one for one in without.effects if one.where == where]:
        probabilities.append(refits.unmodelled(final, refits.without(without, beside)))
    if has_form(final, candidate_effect):
        probabilities.append(refits.locally_unmodelled(final, candidate_effect))
    return max(probabilities)


def _incredible(
    refits: Refits, final: Fit, unmodelled: Mapping[CandidateEffect, float], unexplained: float
) -> list[CandidateEffect]:
    """Effects that are not credible beside an unexplained error, the least credible first."""
    explained = {one: refits.refit(final, removed=one).chi2 - final.chi2 for one in final.effects}
    believable = {one: credibility(unmodelled[one], unexplained, explained[one]) for one in final.effects}
    return sorted((one for one in believable if believable[one] < 1.0 - CERTAIN), key=lambda one: believable[one])


def _helpful(refits: Refits, final: Fit, held_out: HeldOut, progress: Announce) -> Fit:
    """Remove effects that do not improve the prediction of held-out poses, one by one, the least explaining first.

    Remove all if together they do not improve it.
    """
    error = held_out.misfit(final)
    while final.effects:
        progress(f"leaving out each of {len(final.effects)} effects")
        reduced = min((refits.refit(final, removed=one) for one in final.effects), key=lambda fit: fit.chi2)
        if held_out.misfit(reduced) > error:
            break
        final, error = reduced, held_out.misfit(reduced)
    return refits.start if final.effects and error >= held_out.misfit(refits.start) else final
