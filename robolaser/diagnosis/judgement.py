"""The verdict on a final model, with its remaining noise and scatter of poses."""

import typing
from collections.abc import Sequence
from dataclasses import dataclass, replace

from robolaser.diagnosis.findings import gap_of
from robolaser.diagnosis.fit import Fit
from robolaser.diagnosis.held_out_gap import HeldOut, expected_gap
from robolaser.diagnosis.localization import Localization
from robolaser.diagnosis.noise_remarks import as_stated, over_stated
from robolaser.diagnosis.pose_scatter import PartScatter
from robolaser.diagnosis.preparation import Preparation
from robolaser.diagnosis.result import Gap
from robolaser.diagnosis.thresholds import MOST_OVER_STATED
from robolaser.diagnosis.verdict import Evidence, judge
from robolaser.estimation.averaging import AveragedData
from robolaser.model.noise.covariance import NoiseModel


@typing.final
@dataclass(frozen=True)
class Judgement:
    """The verdict on a final model, with its remaining noise, gap and scatter of poses."""

    verdict: str
    noise: NoiseModel
    gap: Gap
    scatter: PartScatter | None = None


def judged(
    preparation: Preparation,
    data: AveragedData,
    start: Fit,
    final: Fit,
    left: Sequence[Localization],
    held_out: HeldOut,
    seed: int,
    *,
    scatters: bool = True,
) -> Judgement:
    """Judge a final model.

    Args:
        preparation: Estimates its noise.
        data: Its rows.
        start: The model without effects.
        final: The model.
        left: Locations of its remaining error.
        held_out: Errors on held-out poses.
        seed: Resamples poses.
        scatters: Whether scatter of whole poses may count as a gap.
    """
    noise = preparation.noise_beside(data, final) if left else final.noise
    gap = gap_of(start, final, noise, held_out, seed)
    if gap.after_ci95_m[1] < gap.noise_floor_m and not left:  # the noise was estimated beside fewer effects
        noise = preparation.noise_beside(data, final)
        gap = gap_of(start, final, noise, held_out, seed)
    verdict = judge(_evidence(start, final, left, gap, noise))
    if verdict == "unexplained" and scatters and (found := preparation.scatter_beside(data, final, smooth=bool(left))):
        beside_gap = gap_of(start, final, found.noise, held_out, seed)
        beside = _evidence(start, final, left, beside_gap, found.noise)
        if beside.is_at_floor:
            return _by_rows(final, judge(beside), found.noise, beside_gap)
        if found.is_excess:
            return Judgement(verdict, found.noise, beside_gap, found)
    return _by_rows(final, verdict, noise, gap)


def _by_rows(final: Fit, verdict: str, noise: NoiseModel, gap: Gap) -> Judgement:
    """The verdict with noise that new poses do not contradict.

    If an unexplained gap is below the noise, the scatter of poses was estimated from the gap: only row noise counts. If
    the estimated row noise is too large for noise, the stated one counts.
    """
    if verdict == "unexplained" and gap.noise_floor_m > gap.after_m:
        of_poses = [source.name for source in noise.sources_of_poses]
        noise = noise.at({name: 0.0 for name in of_poses if noise.origin.get(name) == "estimated"})
        gap = _above(gap, final, noise)
    if verdict == "unexplained" and over_stated(noise) >= MOST_OVER_STATED:
        gap = _above(gap, final, as_stated(noise))
    return Judgement(verdict, noise, gap)


def _above(gap: Gap, final: Fit, noise: NoiseModel) -> Gap:
    """The gap with the noise floor of other noise."""
    turns = gap.rotations and replace(gap.rotations, noise_floor_rad=final.rotation_of(noise))
    return replace(gap, noise_floor_m=final.size_of(noise), rotations=turns)


def _evidence(start: Fit, final: Fit, left: Sequence[Localization], gap: Gap, noise: NoiseModel) -> Evidence:
    known = [name for name in noise.sigmas if noise.origin.get(name, "stated") != "estimated"]
    turns = gap.rotations
    return Evidence(
        chi2_before=start.chi2,
        chi2_after=final.with_likeliest_scatter.chi2,
        localized=sum(one.likelihood_ratio for one in left),
        floor_m=gap.noise_floor_m,
        expected_m=expected_gap(final, noise),
        gap_m=gap.after_m,
        least_m=gap.after_ci95_m[0],
        gap_before_m=gap.calibrated_m,
        has_effects=bool(final.effects),
        estimated_m=final.size_of(noise.at(dict.fromkeys(known, 0.0))),
        spread=final.spread,
        over_stated=over_stated(noise),
        rotations=turns.after_rad / turns.noise_floor_rad if turns else 0.0,
        least_rotations=turns.least_rad / turns.noise_floor_rad if turns else 0.0,
    )
