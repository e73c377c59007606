"""The pipeline from a data set to its diagnosis."""

import time
from collections.abc import Mapping, Sequence
from dataclasses import replace

import numpy as np
from threadpoolctl import threadpool_limits

from robolaser.arrays import Ints, Progress
from robolaser.data.dataset import Dataset
from robolaser.data.joining import check_same_arm
from robolaser.diagnosis.cause_classes import cause_kinds, unknown_at
from robolaser.diagnosis.conclusion import Conclusion
from robolaser.diagnosis.detection_limits import detection_limits
from robolaser.diagnosis.discriminating_poses import next_poses, spread_poses, too_few_poses
from robolaser.diagnosis.evidence import EffectEvidence
from robolaser.diagnosis.findings import (
    findings_of,
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
from robolaser.diagnosis.localization import merged
from robolaser.diagnosis.noise_remarks import noise_remarks
from robolaser.diagnosis.pose_scatter import beside
from robolaser.diagnosis.preparation import Preparation
from robolaser.diagnosis.pruning import prune
from robolaser.diagnosis.refits import Refits
from robolaser.diagnosis.result import Diagnosis
from robolaser.diagnosis.score_tests import library
from robolaser.diagnosis.selection import select
from robolaser.diagnosis.standard_errors import standard_errors
from robolaser.diagnosis.summary_text import exchanged_sentence, imitated_sentence, sentence
from robolaser.diagnosis.thresholds import LEAST_PROBABILITY, SEARCH_LIMIT
from robolaser.diagnosis.validation import validated
from robolaser.diagnosis.verdict import Case
from robolaser.diagnosis.wrong_input import at_other_poses, mispaired
from robolaser.errors import DataError
from robolaser.estimation.averaging import AveragedData
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
    nested, remaining, left = prune(refits, selected, held_out, lambda what: progress(what, 0.6))

    progress("judging the gap", 0.8)
    case = Case(preparation, data, refits, held_out, seed)
    found = Conclusion.of(case, nested, remaining, [] if hindrance else left, scatters=not hindrance)
    final, evidence, verdict, judgement = found.final, found.evidence, found.verdict, found.judgement
    noise, gap, scatter = judgement.noise, judgement.gap, judgement.scatter
    where = [at_other_poses(misread.share)] if misread and misread.shift else merged(found.where)
    classes = unknown_at(found.classes, where)
    if scatter:
        where = beside(where, scatter.located(gap.after_m, gap.noise_floor_m))
    progress("predicting held-out poses", 0.85)
    limits = detection_limits(refits.score_tests(final), refits.score_tests(start))
    whole = preparation.on_all_poses(outliers, final)
    errors = standard_errors(final, refits.score_tests(final), evidence, whole)
    findings = findings_of(refits, found.nested, evidence, held_out, whole, errors)
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


def _next_poses(final: Fit, evidence: Sequence[EffectEvidence], seed: int) -> tuple[Mapping[str, float], ...]:
    """Poses that decide between the least probable listed effect and its best alternative."""
    unsure = [one for one in evidence if one.alternatives]
    if not unsure:
        return ()
    _, rival = min(unsure, key=lambda one: (one.probability < LEAST_PROBABILITY, one.probability)).alternatives[0]
    return next_poses(final, rival, seed=seed)
