"""The pipeline from a data set to its diagnosis."""

import time
from collections.abc import Mapping, Sequence
from dataclasses import replace

import numpy as np
from threadpoolctl import threadpool_limits

from robolaser.arrays import Ints, Progress
from robolaser.data.dataset import Dataset
from robolaser.data.joining import check_same_arm
from robolaser.diagnosis.cause_classes import cause_classes, cause_kinds, class_of, unknown_at, unknown_instead
from robolaser.diagnosis.detection_limits import detection_limits
from robolaser.diagnosis.discriminating_poses import next_poses, spread_poses, too_few_poses
from robolaser.diagnosis.evidence import EffectEvidence
from robolaser.diagnosis.findings import (
    explained_sites,
    findings_of,
    gap_of,
    noise_sources,
    not_testable,
    repeatability_of,
)
from robolaser.diagnosis.fit import Fit
from robolaser.diagnosis.further_poses import Weighed
from robolaser.diagnosis.gravity_direction import with_gravity_turned
from robolaser.diagnosis.gross_errors import rows_sentence
from robolaser.diagnosis.held_out_gap import HeldOut
from robolaser.diagnosis.held_parameters import with_parameters_free
from robolaser.diagnosis.local_unknown import GEOMETRY
from robolaser.diagnosis.localization import Localization, localize, merged
from robolaser.diagnosis.noise_remarks import noise_remarks
from robolaser.diagnosis.pose_scatter import beside
from robolaser.diagnosis.preparation import Preparation
from robolaser.diagnosis.pruning import prune
from robolaser.diagnosis.refits import Refits
from robolaser.diagnosis.result import CauseClass, Diagnosis
from robolaser.diagnosis.score_tests import library
from robolaser.diagnosis.selection import select
from robolaser.diagnosis.standard_errors import standard_errors
from robolaser.diagnosis.summary_text import exchanged_sentence, imitated_sentence, sentence
from robolaser.diagnosis.thresholds import CREDIBLE_MASS, LEAST_PROBABILITY, LEFT_BY_IMITATION, NO_NOISE, SEARCH_LIMIT
from robolaser.diagnosis.validation import validated
from robolaser.diagnosis.verdict import Judgement, judged
from robolaser.diagnosis.wrong_input import at_other_poses, mispaired
from robolaser.errors import DataError
from robolaser.estimation.averaging import AveragedData
from robolaser.estimation.certainty import EVEN
from robolaser.model.effects import EFFECTS, unknown_effect
from robolaser.model.effects.effect import CandidateEffect, Effect


def examine(
    dataset: Dataset,
    effects: Sequence[type[Effect]] | None = None,
    *,
    seed: int = 1,
    without: Sequence[str] = (),
    validate: Sequence[Dataset] = (),
    progress: Progress | None = None,
) -> Diagnosis:
    """Determine where the gap is, which effects cause it, and how far it shrinks, with all that a report shows.

    Args:
        dataset: The measurements, with the nominal parameters.
        effects: The library of effects.
        seed: Seed of all random numbers.
        without: Names of effects to remove from the library.
        validate: Other data of the same arm, for a test of the result.
        progress: Called with the current step and its finished share.

    Raises:
        UsageError: An effect to remove does not exist.
        DataError: The data set has too few data, or other data are of another arm or kind of sensor.

    Examples:
        >>> from robolaser.diagnosis import examine
        >>> examine(dataset, effects=[]).findings
        ()
    """
    began = time.perf_counter()
    for other in validate:
        check_same_arm(dataset, other, f"predicted with what is found on {dataset.name}")
        if other.folder is not None and other.folder == dataset.folder:
            raise DataError("These are the diagnosed data: give independent ones.", file=other.folder)
    announce = progress or (lambda what, share: None)
    with threadpool_limits(limits=1, user_api="blas"):
        kinds = _kinds(effects, without)

        def examined(data: Dataset) -> Diagnosis:
            return _examine(data, kinds, seed, announce, began)

        found = with_gravity_turned(with_parameters_free(examined(dataset), examined, seed), examined)
        if not validate:
            return found
        announce("predicting other data", 0.9)
        found = validated(found, validate, seed)
    return replace(found, seconds=time.perf_counter() - began)


def _kinds(effects: Sequence[type[Effect]] | None, without: Sequence[str]) -> list[type[Effect]]:
    kinds = list(EFFECTS if effects is None else effects)
    for name in without:
        if name not in {kind.name for kind in kinds}:
            raise unknown_effect(name, [kind.name for kind in kinds])
    return [kind for kind in kinds if kind.name not in without]


def _examine(dataset: Dataset, kinds: list[type[Effect]], seed: int, progress: Progress, began: float) -> Diagnosis:
    too_few = too_few_poses(dataset)
    progress("fitting the nominal model", 0.0)
    preparation = Preparation.of(dataset, seed)
    calibration = preparation.calibration
    misread = None if too_few else preparation.misread()
    hindrance = too_few or (misread.sentence if misread else "")
    effects = [] if hindrance or preparation.is_far_off else library(kinds, dataset)
    data, refits, selected, outliers = _selected(preparation, effects, progress)
    start = refits.start

    progress("weighing the evidence", 0.6)
    held_out = HeldOut(start, seed, calibration, selected)
    nested, evidence, left = prune(refits, selected, held_out, lambda what: progress(what, 0.6))
    final = nested[-1]

    progress("judging the gap", 0.8)
    left = [] if hindrance else left
    judgement = judged(preparation, data, start, final, left, held_out, seed, scatters=not hindrance)
    classes = cause_classes(judgement.verdict, refits, final, evidence, left, held_out, judgement.scatter)
    hidden = _unreported(evidence, classes)
    if hidden and len(hidden) == len(final.effects):
        judgement, left = _of_imitated(preparation, data, start, final, evidence, judgement, held_out, seed)
        final, nested, evidence = start, [start], []
        classes = cause_classes(judgement.verdict, refits, final, evidence, left, held_out, judgement.scatter)
    verdict, noise, gap, scatter = judgement.verdict, judgement.noise, judgement.gap, judgement.scatter
    if verdict == "explained" and hidden:  # the reported effects alone must close the gap
        reported = refits.without(final, hidden)
        if held_out.gap(reported) > NO_NOISE * gap.noise_floor_m:
            verdict, left = "unexplained", localize(reported)
            classes = cause_classes(verdict, refits, final, evidence, left, held_out, scatter)
    if scatter and left:
        share = scatter.located(gap.after_m, gap.noise_floor_m).share
        scatter = replace(scatter, share=share) if share >= EVEN else None
        if scatter:
            left = [] if share >= CREDIBLE_MASS else scatter.remainder(final, left)
        classes = cause_classes(verdict, refits, final, evidence, left, held_out, scatter)
    where = left if scatter else _where(verdict, refits, final, evidence, left)
    if verdict == "explained" and unknown_instead(classes):
        verdict, where = "unexplained", localize(start) or where
    where = [at_other_poses(misread.share)] if misread and misread.shift else merged(where)
    classes = unknown_at(classes, where)
    if scatter:
        where = beside(where, scatter.located(gap.after_m, gap.noise_floor_m))
    progress("predicting held-out poses", 0.85)
    limits = detection_limits(refits.score_tests(final), refits.score_tests(start))
    whole = preparation.on_all_poses(outliers, final)
    errors = standard_errors(final, refits.score_tests(final), evidence, whole)
    findings = findings_of(refits, nested, evidence, held_out, whole, errors)
    repeatability = repeatability_of(final, noise)
    odd = "" if misread else rows_sentence(final, noise, verdict, dataset, outliers)
    moved = misread.shift if misread else len(preparation.belongs)
    return Diagnosis(
        dataset=dataset,
        verdict=verdict,
        sentence=sentence(verdict, findings, classes, where, gap, repeatability, odd, scatter, hindrance)
        + imitated_sentence(limits, classes)
        + exchanged_sentence(preparation.belongs, dataset.poses.names),
        gap=gap,
        where=tuple(where),
        findings=tuple(one for one in findings if one.probability >= LEAST_PROBABILITY),
        kinds=cause_kinds(refits, final, evidence, held_out) if verdict != "no_gap" else (),
        classes=classes,
        outliers=outliers,
        not_testable=not_testable(kinds, dataset, limits, enough=not too_few),
        next_poses=spread_poses(final, seed=seed) if too_few else _next_poses(final, evidence, seed),
        limits=limits,
        model=final.model,
        x=held_out.of(final).x if whole is final else whole.x,
        std=np.where(final.at.free, errors, np.nan),
        calibrated_x=calibration.x,
        unseen=held_out.of(final).folds,
        before_m=held_out.of(start).in_metres,
        after_m=held_out.of(final).in_metres,
        noise=noise_sources(noise),
        repeatability=repeatability,
        odd_rows=odd,
        noise_remarks=noise_remarks(final, noise, dataset, fits=verdict != "unexplained"),
        seconds=time.perf_counter() - began,
        hindrance=hindrance,
        wrong_input=mispaired(moved, gap.calibrated_m) if moved else None,
        pose_scatter=scatter,
        weighed=Weighed(start, final, evidence, start.model.dataset),
        belongs=preparation.belongs,
    )


def _selected(
    preparation: Preparation, effects: Sequence[CandidateEffect], progress: Progress
) -> tuple[AveragedData, Refits, Fit, Ints]:
    """Select effects: return the rows used, all fits, the set of effects with the lowest cost, and the excluded rows.

    Noise and gross errors are estimated from a model's residuals, and again once effects are in the model.
    """
    data, outliers, start = preparation.weighted.data, preparation.weighted.outliers, preparation.fit(effects)
    refits = Refits(start, effects)
    final = select(refits, progress=lambda what: progress(what, 0.3))

    def reselected(start: Fit, share: float) -> tuple[Refits, Fit]:
        fresh = Refits(start, effects)
        rival = refits.separate and fresh.warm_start(refits.separate, refits)
        return fresh, select(fresh, fresh.warm_start(final, refits), rival, lambda what: progress(what, share))

    for left in reversed(range(SEARCH_LIMIT + 1)):
        for _ in range(SEARCH_LIMIT):
            if (other := preparation.with_other_noise(data, start, final)) is None:
                break
            start = other
            refits, final = reselected(start, 0.4)
        found = preparation.outliers(final)
        if not left or np.array_equal(found, outliers):
            break
        outliers = found
        data, start = preparation.without(outliers, start)
        refits, final = reselected(start, 0.5)
    return data, refits, final, np.flatnonzero(outliers).astype(np.int64)


def _of_imitated(
    preparation: Preparation,
    data: AveragedData,
    start: Fit,
    imitating: Fit,
    evidence: Sequence[EffectEvidence],
    found: Judgement,
    held_out: HeldOut,
    seed: int,
) -> tuple[Judgement, list[Localization]]:
    """The judgement without the effects of a model, which only imitate a cause, and the locations of the error.

    If they predict most of the error on new poses, this is neither noise nor scatter: it is at their sites.
    """
    left = localize(start)
    judgement = judged(preparation, data, start, start, left, held_out, seed)
    scatter, leaves = judgement.scatter, (held_out.gap(imitating) / held_out.gap(start)) ** 2
    is_noise = judgement.verdict == "no_gap" or scatter is not None
    if not is_noise or leaves > LEFT_BY_IMITATION or not held_out.lowers(start, imitating):
        return judgement, left
    sites = explained_sites(start, imitating, evidence, 1)
    if scatter and scatter.where != sites[0].site:
        return judgement, left
    return Judgement("unexplained", found.noise, gap_of(start, start, found.noise, held_out, seed)), sites


def _unreported(evidence: Sequence[EffectEvidence], classes: Sequence[CauseClass]) -> list[CandidateEffect]:
    """Effects of a model that, like their class, are too improbable to be reported."""
    likely = {one.name for one in classes if one.probability >= EVEN}
    improbable = (one.candidate_effect for one in evidence if one.probability < LEAST_PROBABILITY)
    return [one for one in improbable if class_of(one) not in likely]


def _where(
    verdict: str, refits: Refits, final: Fit, evidence: Sequence[EffectEvidence], left: list[Localization]
) -> list[Localization]:
    """Locations of an explained gap, or of what likely effects leave. Placements have no form that could be wrong."""
    if verdict == "no_gap":
        return []
    if verdict == "explained":
        return explained_sites(refits.start, final, evidence, len(refits.effects))
    doubted = [one.candidate_effect for one in evidence if one.probability < EVEN]
    formed = [one for one in doubted if one.effect.cause != GEOMETRY]
    return localize(refits.without(final, formed)) if formed else left


def _next_poses(final: Fit, evidence: Sequence[EffectEvidence], seed: int) -> tuple[Mapping[str, float], ...]:
    """Poses that decide between the least probable listed effect and its best alternative."""
    unsure = [one for one in evidence if one.alternatives]
    if not unsure:
        return ()
    _, rival = min(unsure, key=lambda one: (one.probability < LEAST_PROBABILITY, one.probability)).alternatives[0]
    return next_poses(final, rival, seed=seed)
