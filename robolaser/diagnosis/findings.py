"""The findings of a diagnosis: the gap step by step, noise, effects with their parameters, and untestable effects."""

from collections.abc import Mapping, Sequence
from itertools import pairwise

import numpy as np
from scipy.special import chdtrc

from robolaser.arrays import Array
from robolaser.calibration.result import rms
from robolaser.data.dataset import Dataset
from robolaser.diagnosis.cause_words import site_phrase
from robolaser.diagnosis.evidence import EffectEvidence
from robolaser.diagnosis.fit import Fit
from robolaser.diagnosis.held_out_gap import HeldOut, distance_errors, interval
from robolaser.diagnosis.local_unknown import GEOMETRY
from robolaser.diagnosis.localization import Localization, corrected, localize
from robolaser.diagnosis.pose_coordinates import TIME
from robolaser.diagnosis.refits import Refits
from robolaser.diagnosis.result import (
    Alternative,
    DetectionLimit,
    Estimate,
    Finding,
    Gap,
    NoiseSource,
    Repeatability,
    RotationGap,
)
from robolaser.diagnosis.score_tests import lack_of_poses
from robolaser.diagnosis.standard_errors import standard_errors
from robolaser.diagnosis.thresholds import SEARCH_LIMIT
from robolaser.estimation.certainty import EVEN
from robolaser.estimation.outliers import MIN_POSES
from robolaser.model.effects.effect import CandidateEffect, Effect
from robolaser.model.effects.requirements import SensorLacks
from robolaser.model.noise.covariance import NoiseModel


def findings_of(
    refits: Refits,
    nested: Sequence[Fit],
    evidence: Sequence[EffectEvidence],
    held_out: HeldOut,
    whole: Fit,
    errors: Array,
) -> tuple[Finding, ...]:
    """Each effect with its gaps, in the order of `nested`, and parameters of the fit to all poses with errors (d,)."""
    by_effect = {one.candidate_effect: one for one in evidence}
    findings = []
    for before, after in pairwise(nested):
        (added,) = set(after.effects) - set(before.effects)
        own = by_effect[added]
        findings.append(
            Finding(
                candidate_effect=added,
                probability=own.probability,
                parameters=_estimates(whole, added, errors),
                gap_before_m=held_out.gap(before),
                gap_after_m=held_out.gap(after),
                gap_without_m=held_out.gap_without(refits.of(own.without)),
                alternatives=tuple(
                    Alternative(one, _estimates(fit, one, standard_errors(fit)), held_out.gap(fit))
                    for one, fit in own.alternatives[:SEARCH_LIMIT]
                ),
            )
        )
    return tuple(findings)


def gap_of(start: Fit, final: Fit, noise: NoiseModel, held_out: HeldOut, seed: int) -> Gap:
    """The held-out gap of the nominal, the calibrated and the final model."""
    pose, after, rotations = start.model.dataset.points.pose, held_out.of(final), None
    if start.model.dataset.format.angles:
        rotated = held_out.rotation_errors(final)
        least = interval(rotated, pose, seed)[0]
        rotations = RotationGap(rms(held_out.rotation_errors(start)), rms(rotated), least, final.rotation_of(noise))
    calibrated = held_out.calibrated(start, final)
    known = start.model.known_distances is not None
    return Gap(
        nominal_m=_nominal_gap(start, calibrated),
        calibrated_m=calibrated,
        after_m=rms(after.in_metres),
        noise_floor_m=final.size_of(noise),
        after_ci95_m=interval(after.in_metres, pose, seed),
        rotations=rotations,
        is_held_out=after.folds is not None,
        distances_m=(rms(distance_errors(start)[:, None]), rms(distance_errors(final)[:, None])) if known else None,
    )


def noise_sources(noise: NoiseModel) -> dict[str, NoiseSource]:
    """The sources of noise, by name."""
    return {
        one.name: NoiseSource(
            float(noise.sigmas[one.name]), one.unit, noise.origin.get(one.name, "stated"), one.level == "pose"
        )
        for one in noise.sources
    }


def repeatability_of(fit: Fit, noise: NoiseModel) -> Repeatability:
    """The scatter of whole poses, without row noise."""
    of_poses = noise.at({source.name: 0.0 for source in noise.sources if source.level != "pose"})
    zero = noise.at(dict.fromkeys(noise.sigmas, 0.0))
    sources = {name: source for name, source in noise_sources(noise).items() if source.of_poses}
    stated = fit.model.dataset.noise.repeatability_m
    at_sensor_m = float(np.sqrt(fit.size_of(of_poses) ** 2 - fit.size_of(zero) ** 2))
    return Repeatability(sources, at_sensor_m, stated is not None)


def _nominal_gap(start: Fit, calibrated: float) -> float | None:
    """The nominal model's error; None without a nominal model, which needs the sensor's parameters and mount.

    Unmeasured positions of things set up for a campaign are fitted. If nothing else is unknown and nothing is given,
    the nominal model is the arm.
    """
    items, blocks = start.sensor.items, start.model.blocks
    lasting = {*blocks.free, *blocks.derived} - {*blocks.setup_parameters}
    if any(not item.given and item.name in lasting for item in items):
        return None
    if any(item.given for item in items):
        x = start.problem.parameters.nominal
        return rms(start.model.in_metres(x, start.problem.plain(x[None])[0]))
    return None if start.model.dataset.robot is None else calibrated


def _estimates(fit: Fit, candidate_effect: CandidateEffect, errors: Array) -> Mapping[str, Estimate]:
    problem = fit.problem
    names, prior = problem.parameters.names, problem.prior
    assert prior is not None  # `problem_of` has it

    def std(i: int) -> float | None:
        return float(errors[i]) if fit.at.free[i] and fit.deviations[i] < EVEN * prior[i] else None

    def estimate(i: int) -> Estimate:
        low, high = (side[i] for side in fit.at.touching)
        unit = problem.parameters.items[i].unit
        return Estimate(float(fit.x[i]), std(i), unit, "upper" if high else "lower" if low else "")

    return {name.rsplit(".", 1)[1]: estimate(names.index(name)) for name in candidate_effect.parameters.names}


def explained_sites(start: Fit, final: Fit, evidence: Sequence[EffectEvidence], tried: int) -> list[Localization]:
    """Locations of an explained gap, with the share that each effect explains.

    Of several effects at one site, the least likely by chance gives the site's coordinate, and its p value, corrected
    for the number of candidates that were tried.
    """
    excess = max(start.chi2 - start.freedoms, 1e-9)
    closed = float(np.clip((start.chi2 - final.chi2) / excess, 0.0, 1.0))
    total = max(sum(one.explained for one in evidence), 1e-9)
    located = localize(start)
    by_site: dict[str, list[EffectEvidence]] = {}
    for one in sorted(evidence, key=lambda one: (_chance(one), -one.explained, one.candidate_effect.effect.name)):
        by_site.setdefault(one.candidate_effect.where, []).append(one)
    found = [
        Localization(
            site,
            _coordinate(own[0].candidate_effect.effect, site, located),
            closed * sum(one.explained for one in own) / total,
            own[0].explained,
            corrected(_chance(own[0]), tried),
        )
        for site, own in by_site.items()
    ]
    return sorted(found, key=lambda one: -one.share)


def _chance(one: EffectEvidence) -> float:
    """Probability that a given candidate explains as much of pure noise."""
    return float(chdtrc(len(one.candidate_effect.effect.units()), max(one.explained, 0.0)))


def _coordinate(kind: type[Effect], site: str, located: Sequence[Localization]) -> str:
    """The coordinate of an unknown function at an effect's location, if the effect may depend on it; else its title.

    Constants of the arm depend on no coordinate, and only effects that depend on the trajectory depend on time.
    """
    own = [one.coordinate for one in located if one.site == site and kind.cause != GEOMETRY]
    return next((one for one in own if one != TIME or kind.depends_on_trajectory), kind.title)


def not_testable(
    kinds: Sequence[type[Effect]], dataset: Dataset, limits: Sequence[DetectionLimit], *, enough: bool
) -> dict[str, str]:
    """Why effects could not be tested, by name, without effects that this kind of sensor cannot have."""
    missing = {kind.name: kind.missing(dataset) or lack_of_poses(kind, dataset) for kind in kinds}
    reasons = {name: reason for name, reason in missing.items() if not isinstance(reason, SensorLacks)}
    if not enough:
        return dict.fromkeys(reasons, f"fewer than {MIN_POSES} poses with points differ")
    reasons = {name: reason for name, reason in reasons.items() if reason}
    unseen: dict[str, list[str]] = {}
    for one in limits:
        if one.size is None and not one.is_imitated:
            unseen.setdefault(one.candidate_effect.effect.name, []).append(one.candidate_effect.where)
    for name, locations in unseen.items():
        where = ", ".join(map(site_phrase, locations))
        reasons.setdefault(name, f"undetectable at {where} in these poses, at any plausible size")
    return reasons
