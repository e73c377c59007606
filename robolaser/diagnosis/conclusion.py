"""The conclusion from the fits to a data set: the verdict, the classes of causes, and the locations of the gap."""

from collections.abc import Sequence
from dataclasses import dataclass, replace
from functools import cached_property
from typing import final

from robolaser.diagnosis.cause_classes import cause_classes, class_of, unknown_instead
from robolaser.diagnosis.evidence import EffectEvidence
from robolaser.diagnosis.findings import explained_sites
from robolaser.diagnosis.fit import Fit
from robolaser.diagnosis.local_unknown import GEOMETRY
from robolaser.diagnosis.localization import Localization, localize
from robolaser.diagnosis.result import CauseClass
from robolaser.diagnosis.thresholds import CREDIBLE_MASS, LEAST_PROBABILITY, LEFT_BY_IMITATION, NO_NOISE
from robolaser.diagnosis.verdict import Case, Judgement, judged
from robolaser.estimation.certainty import EVEN
from robolaser.model.effects.effect import CandidateEffect


@final
@dataclass(frozen=True, eq=False)
class Conclusion:
    """A final model, and what it says of the gap."""

    case: Case
    nested: Sequence[Fit]  # the model without effects, then with each one of the final model added
    evidence: Sequence[EffectEvidence]  # for each effect of the final model
    left: Sequence[Localization]  # locations of its remaining error
    judgement: Judgement

    @classmethod
    def of(
        cls,
        case: Case,
        nested: Sequence[Fit],
        evidence: Sequence[EffectEvidence],
        left: Sequence[Localization],
        *,
        scatters: bool,
    ) -> "Conclusion":
        """Judge a final model; scatter of whole poses may count as a gap."""
        found = cls(case, nested, evidence, left, judged(case, nested[-1], left, scatters=scatters))
        return _beside_scatter(_by_reported_effects(_without_imitations(found)))

    @property
    def final(self) -> Fit:
        """The final model."""
        return self.nested[-1]

    @cached_property
    def classes(self) -> tuple[CauseClass, ...]:
        """Every class of causes that may be present."""
        judgement, case = self.judgement, self.case
        return cause_classes(
            judgement.verdict, case.refits, self.final, self.evidence, self.left, case.held_out, judgement.scatter
        )

    @cached_property
    def unreported(self) -> list[CandidateEffect]:
        """Effects of the final model that, like their class, are too improbable to be reported."""
        improbable = [one.candidate_effect for one in self.evidence if one.probability < LEAST_PROBABILITY]
        likely = {one.name for one in self.classes if one.probability >= EVEN} if improbable else ()
        return [one for one in improbable if class_of(one) not in likely]

    @property
    def is_imitated(self) -> bool:
        """Whether effects close the gap, but an unknown cause is likelier than each of their classes."""
        return self.judgement.verdict == "explained" and unknown_instead(self.classes) is not None

    @property
    def verdict(self) -> str:
        """`no_gap`, `explained` or `unexplained`."""
        return "unexplained" if self.is_imitated else self.judgement.verdict

    @property
    def where(self) -> Sequence[Localization]:
        """Locations of an explained gap, or of what likely effects leave. A placement has no form to be wrong."""
        verdict, refits = self.judgement.verdict, self.case.refits
        if verdict == "no_gap":
            return []
        if verdict == "explained":
            located = localize(refits.start) if self.is_imitated else []
            return located or explained_sites(refits.start, self.final, self.evidence, len(refits.effects))
        doubted = [one.candidate_effect for one in self.evidence if one.probability < EVEN]
        formed = [one for one in doubted if one.effect.cause != GEOMETRY]
        return localize(refits.without(self.final, formed)) if formed and not self.judgement.scatter else self.left


def _without_imitations(found: Conclusion) -> Conclusion:
    """The conclusion from the model without effects, if none of those found is reported: they only imitate a cause.

    If they predict most of the error on new poses, this is neither noise nor scatter: it is at their sites.
    """
    if not found.final.effects or len(found.unreported) < len(found.final.effects):
        return found
    case = found.case
    start, held_out, left = case.refits.start, case.held_out, localize(case.refits.start)
    alone = Conclusion(case, [start], [], left, judged(case, start, left))
    scatter, leaves = alone.judgement.scatter, (held_out.gap(found.final) / held_out.gap(start)) ** 2
    is_noise = alone.judgement.verdict == "no_gap" or scatter is not None
    if not is_noise or leaves > LEFT_BY_IMITATION or not held_out.lowers(start, found.final):
        return alone
    sites = explained_sites(start, found.final, found.evidence, 1)
    if scatter and scatter.where != sites[0].site:
        return alone
    noise = found.judgement.noise
    return replace(alone, left=sites, judgement=Judgement("unexplained", noise, case.gap(start, noise)))


def _by_reported_effects(found: Conclusion) -> Conclusion:
    """The conclusion where the reported effects alone must close the gap."""
    if found.judgement.verdict != "explained" or not found.unreported:
        return found
    reported = found.case.refits.without(found.final, found.unreported)
    if found.case.held_out.gap(reported) <= NO_NOISE * found.judgement.gap.noise_floor_m:
        return found
    return replace(found, left=localize(reported), judgement=replace(found.judgement, verdict="unexplained"))


def _beside_scatter(found: Conclusion) -> Conclusion:
    """The conclusion with the locations that scatter of poses leaves; without scatter that leaves most of the gap."""
    scatter, gap = found.judgement.scatter, found.judgement.gap
    if not scatter or not found.left:
        return found
    share = scatter.located(gap.after_m, gap.noise_floor_m).share
    if share < EVEN:
        return replace(found, judgement=replace(found.judgement, scatter=None))
    scatter = replace(scatter, share=share)
    left = [] if share >= CREDIBLE_MASS else scatter.remainder(found.final, found.left)
    return replace(found, left=left, judgement=replace(found.judgement, scatter=scatter))
