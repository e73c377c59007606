"""The verdict on a final model, with its remaining noise and scatter of poses."""

from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import final

import numpy as np

from robolaser.calibration.checks import SETUP_RMS_M
from robolaser.diagnosis.findings import gap_of
from robolaser.diagnosis.fit import Fit
from robolaser.diagnosis.held_out_gap import HeldOut, expected_gap
from robolaser.diagnosis.localization import Localization
from robolaser.diagnosis.noise_remarks import as_stated, over_stated
from robolaser.diagnosis.pose_scatter import PartScatter
from robolaser.diagnosis.preparation import Preparation
from robolaser.diagnosis.refits import Refits
from robolaser.diagnosis.result import Gap
from robolaser.diagnosis.thresholds import (
    MOST_OVER_STATED,
    NO_DIFFERENCE,
    NO_NOISE,
    OPEN_SHARE,
    SIGMA_OF_95_PERCENT,
    SIGMA_WITHOUT_LOCATION,
    SMALL_SHARE,
)
from robolaser.estimation.averaging import AveragedData
from robolaser.model.noise.covariance import NoiseModel


@final
@dataclass(frozen=True)
class Evidence:
    """What determines a verdict."""

    gap: Gap
    expected_m: float  # expected root-mean-square error of a held-out row by noise and the parameters' errors [m]
    explained: float  # decrease of chi-squared by the effects found
    has_effects: bool
    localized: float  # sum of the likelihood ratios of all sites of the remaining error
    estimated_m: float  # size of noise estimated from residuals alone [m]; centimetres mean that the model is wrong
    scatter_m: float = 0.0  # size of the scatter of poses that was estimated [m]
    spread: float = 1.0  # unevenness of the error over the rows, see `spread_of`
    over_stated: float = 0.0  # largest ratio of estimated to stated row noise; 0 if none is stated

    @classmethod
    def of(cls, start: Fit, final: Fit, left: Sequence[Localization], gap: Gap, noise: NoiseModel) -> "Evidence":
        """For a final model, from its remaining noise and gap."""
        known = [name for name in noise.sigmas if noise.origin.get(name, "stated") != "estimated"]
        scatter_m2 = final.size_of(noise) ** 2 - final.size_of(_of_rows(noise)) ** 2
        return cls(
            gap=gap,
            expected_m=expected_gap(final, noise),
            explained=start.chi2 - final.with_likeliest_scatter.chi2,
            has_effects=bool(final.effects),
            localized=sum(one.likelihood_ratio for one in left),
            estimated_m=final.size_of(noise.at(dict.fromkeys(known, 0.0))),
            scatter_m=np.sqrt(max(scatter_m2, 0.0)),
            spread=final.spread,
            over_stated=over_stated(noise),
        )

    @property
    def is_noise(self) -> bool:
        """Whether the noise estimated from residuals can be noise: new poses show no less than the scatter of poses."""
        is_small = self.estimated_m < SETUP_RMS_M and self.over_stated < MOST_OVER_STATED
        return is_small and max(self.spread, self.scatter_m / (self.gap.after_m or np.inf)) < NO_NOISE

    @property
    def is_near_floor(self) -> bool:
        """Whether the held-out gap, and that of rotations, is hardly larger than by noise alone."""
        return self.gap.after_m <= NO_DIFFERENCE * self.gap.noise_floor_m and self._rotations_at_floor

    @property
    def is_at_floor(self) -> bool:
        """Whether the held-out gap is that of noise: near it, or not significantly above it."""
        least_m = self._least(self.gap.after_m, self.gap.after_ci95_m[0])
        return self.is_near_floor or (least_m <= self.expected_m and self._rotations_at_floor)

    @property
    def _rotations_at_floor(self) -> bool:
        if (turns := self.gap.rotations) is None:
            return True
        after, lower = turns.after_rad / turns.noise_floor_rad, turns.least_rad / turns.noise_floor_rad
        least, floor_m = min(after / NO_DIFFERENCE, self._least(after, lower)), self.gap.noise_floor_m
        return least * floor_m <= max(floor_m, self.expected_m)

    def _least(self, gap: float, lower: float) -> float:
        """The least plausible value of a gap, from the lower end of its interval: a lower one without a location."""
        if self.localized > 0.0 or gap <= 0.0:
            return lower
        return float(gap * (lower / gap) ** (SIGMA_WITHOUT_LOCATION / SIGMA_OF_95_PERCENT))

    @property
    def is_closed(self) -> bool:
        """Whether the held-out gap is near the noise floor, or a negligible share of a far larger one."""
        after_m, floor_m = self.gap.after_m, self.gap.noise_floor_m
        left_m2, before_m2 = (gap_m**2 - floor_m**2 for gap_m in (after_m, self.gap.calibrated_m))
        return self.is_near_floor or (left_m2 <= OPEN_SHARE * before_m2 and after_m <= NO_NOISE * floor_m)


def judge(evidence: Evidence) -> str:
    """Return `no_gap`, `explained` or `unexplained`, first of all by the held-out gap against the noise floor.

    Chi-squared alone is not enough: a free scatter of whole poses explains any gap.
    """
    closed = evidence.has_effects and evidence.is_closed
    if not (evidence.is_noise and (evidence.is_at_floor or closed)):
        return "unexplained"
    if evidence.localized <= 0.0:
        return "explained" if evidence.has_effects else "no_gap"
    return "explained" if closed and evidence.localized <= SMALL_SHARE * evidence.explained else "unexplained"


@final
@dataclass(frozen=True)
class Judgement:
    """The verdict on a final model, with its remaining noise, gap and scatter of poses."""

    verdict: str
    noise: NoiseModel
    gap: Gap
    scatter: PartScatter | None = None


@final
@dataclass(frozen=True, eq=False)
class Case:
    """A data set with its fits, and their errors on held-out poses."""

    preparation: Preparation
    data: AveragedData  # the rows used
    refits: Refits
    held_out: HeldOut
    seed: int  # of resampling

    def gap(self, final: Fit, noise: NoiseModel) -> Gap:
        """The held-out gap of the nominal, the calibrated and a final model."""
        return gap_of(self.refits.start, final, noise, self.held_out, self.seed)

    def evidence(self, final: Fit, left: Sequence[Localization], gap: Gap, noise: NoiseModel) -> Evidence:
        """What determines the verdict on a final model."""
        return Evidence.of(self.refits.start, final, left, gap, noise)


def judged(case: Case, final: Fit, left: Sequence[Localization], *, scatters: bool = True) -> Judgement:
    """Judge a final model with the locations of its remaining error; scatter of whole poses may count as a gap."""
    preparation, data = case.preparation, case.data
    noise = preparation.noise_beside(data, final) if left else final.noise
    gap = case.gap(final, noise)
    if gap.after_ci95_m[1] < gap.noise_floor_m and not left:  # the noise was estimated beside fewer effects
        noise = preparation.noise_beside(data, final)
        gap = case.gap(final, noise)
    verdict = judge(case.evidence(final, left, gap, noise))
    if verdict == "unexplained" and scatters and (found := preparation.scatter_beside(data, final, smooth=bool(left))):
        beside_gap = case.gap(final, found.noise)
        beside = case.evidence(final, left, beside_gap, found.noise)
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
        noise = _of_rows(noise)
        gap = _above(gap, final, noise)
    if verdict == "unexplained" and over_stated(noise) >= MOST_OVER_STATED:
        gap = _above(gap, final, as_stated(noise))
    return Judgement(verdict, noise, gap)


def _of_rows(noise: NoiseModel) -> NoiseModel:
    """Noise without the scatter of poses that was estimated."""
    of_poses = [source.name for source in noise.sources_of_poses]
    return noise.at({name: 0.0 for name in of_poses if noise.origin.get(name) == "estimated"})


def _above(gap: Gap, final: Fit, noise: NoiseModel) -> Gap:
    """The gap with the noise floor of other noise."""
    turns = gap.rotations and replace(gap.rotations, noise_floor_rad=final.rotation_of(noise))
    return replace(gap, noise_floor_m=final.size_of(noise), rotations=turns)
