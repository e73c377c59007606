"""Penalties, probabilities and the verdict of a diagnosis, as pure functions of numbers."""

from dataclasses import dataclass
from typing import final

import numpy as np
from scipy.special import softmax

from robolaser.arrays import Array, Ints
from robolaser.calibration.checks import SETUP_RMS_M
from robolaser.diagnosis.thresholds import (
    CHI2_PER_EFFECT,
    CHI2_PER_FURTHER_PARAMETER,
    CHI2_PER_PARAMETER,
    FORM_SHARE,
    FULLY_PENALIZED,
    LEAST_TYPICAL,
    MOST_OVER_STATED,
    NO_DIFFERENCE,
    NO_NOISE,
    OPEN_SHARE,
    SIGMA_OF_95_PERCENT,
    SIGMA_WITHOUT_LOCATION,
    SMALL_SHARE,
)
from robolaser.estimation.outliers import median_length


def complexity_penalty(parameters: int, shapes: int) -> float:
    """Chi-squared that an effect must explain to enter the model.

    Args:
        parameters: Number of its linear and nonlinear parameters.
        shapes: Number of shapes, by its nonlinear parameters, that the best was selected from.
    """
    further = max(0, parameters - FULLY_PENALIZED)
    each = CHI2_PER_PARAMETER * (parameters - further) + CHI2_PER_FURTHER_PARAMETER * further
    return CHI2_PER_EFFECT + each + 2.0 * float(np.log(shapes))


def posterior_weights(costs: Array) -> Array:
    """Probabilities of models, one of them true, from their costs in chi-squared, (n,) each."""
    return np.asarray(softmax(-0.5 * costs))


def credibility(unmodelled: float, unexplained: float, explained: float) -> float:
    """Probability that an effect, not an unmodelled cause, explains its part of chi-squared.

    Args:
        unmodelled: Probability of an unmodelled cause instead.
        unexplained: Chi-squared that no effect of the model explains.
        explained: Increase of chi-squared without this effect.
    """
    return (1.0 - unmodelled) / (1.0 + unexplained / (SMALL_SHARE * max(explained, 1e-9)))


def is_indistinguishable(chi2: float, chi2_of_alternative: float) -> bool:
    """Whether an alternative to an effect fits nearly as well."""
    return chi2_of_alternative - chi2 < CHI2_PER_EFFECT


def spread_of(squares: Array, numbers: Ints) -> float:
    """Ratio of the root mean square of whitened rows to that expected from their median: 1 for normal noise.

    It is larger if a part of the rows has most of the error: noise estimated from them is no noise of all rows.

    Args:
        squares: Squared lengths of the rows, (m,).
        numbers: Number of values of each row, (m,).
    """
    typical = np.median(np.sqrt(squares) / median_length(numbers))
    return float(np.sqrt(squares.sum() / numbers.sum()) / max(typical, LEAST_TYPICAL))


@final
@dataclass(frozen=True)
class Evidence:
    """The numbers that determine a verdict."""

    chi2_before: float  # chi-squared of the model without effects
    chi2_after: float  # chi-squared of the model with the effects found
    localized: float  # sum of the likelihood ratios of all sites of the remaining error
    floor_m: float  # root-mean-square error of a row by noise: the noise floor of the gap [m]
    expected_m: float  # expected root-mean-square error of a held-out row by noise and the parameters' errors [m]
    gap_m: float  # remaining held-out gap [m]
    least_m: float  # lower end of its interval, from resampled poses [m]
    gap_before_m: float  # held-out gap of the model without effects [m]
    has_effects: bool  # whether any effect was found
    # size of noise that is estimated from residuals alone [m]; centimetres mean that the model is wrong
    estimated_m: float
    rotations: float = 0.0  # ratio of the held-out error of rotations to that of a row by noise; 0 if none are measured
    least_rotations: float = 0.0  # lower end of its interval
    spread: float = 1.0  # unevenness of the error over the rows, see `spread_of`
    over_stated: float = 0.0  # largest ratio of estimated to stated row noise; 0 if none is stated

    @property
    def is_noise(self) -> bool:
        """Whether the row noise estimated from residuals can be noise."""
        is_small = self.estimated_m < SETUP_RMS_M and self.over_stated < MOST_OVER_STATED
        return is_small and self.spread < NO_NOISE

    @property
    def is_near_floor(self) -> bool:
        """Whether the held-out gap, and that of rotations, is hardly larger than by noise alone."""
        return self.gap_m <= NO_DIFFERENCE * self.floor_m and self._rotations_at_floor

    @property
    def is_at_floor(self) -> bool:
        """Whether the held-out gap is that of noise: near it, or not significantly above it."""
        return self.is_near_floor or (
            self._least(self.gap_m, self.least_m) <= self.expected_m and self._rotations_at_floor
        )

    @property
    def _rotations_at_floor(self) -> bool:
        expected = max(self.floor_m, self.expected_m)
        least = self._least(self.rotations, self.least_rotations)
        return min(self.rotations / NO_DIFFERENCE, least) * self.floor_m <= expected

    def _least(self, gap: float, lower: float) -> float:
        """The least plausible value of a gap, from the lower end of its interval: a lower one without a location."""
        if self.localized > 0.0 or gap <= 0.0:
            return lower
        return float(gap * (lower / gap) ** (SIGMA_WITHOUT_LOCATION / SIGMA_OF_95_PERCENT))

    @property
    def is_closed(self) -> bool:
        """Whether the held-out gap is near the noise floor, or a negligible share of a far larger one."""
        left_m2, before_m2 = (gap**2 - self.floor_m**2 for gap in (self.gap_m, self.gap_before_m))
        return self.is_near_floor or (left_m2 <= OPEN_SHARE * before_m2 and self.gap_m <= NO_NOISE * self.floor_m)


def judge(evidence: Evidence) -> str:
    """Return `no_gap`, `explained` or `unexplained`, first of all by the held-out gap against the noise floor.

    Chi-squared alone is not enough: a free scatter of whole poses explains any gap.
    """
    explained = evidence.chi2_before - evidence.chi2_after
    closed = evidence.has_effects and evidence.is_closed
    if not (evidence.is_noise and (evidence.is_at_floor or closed)):
        return "unexplained"
    if evidence.localized <= 0.0:
        return "explained" if evidence.has_effects else "no_gap"
    return "explained" if closed and evidence.localized <= FORM_SHARE * explained else "unexplained"
