"""The part of residuals that parameters, effects and smooth functions explain; the rest is scatter of whole poses."""

from collections.abc import Sequence

import numpy as np

from robolaser.arrays import Array
from robolaser.diagnosis.effect_columns import Columns, prior_scales
from robolaser.diagnosis.fit import MOST_STEPS, Fit
from robolaser.diagnosis.localization import smooth_remainder
from robolaser.diagnosis.refits import Refits
from robolaser.diagnosis.thresholds import OPEN_SHARE
from robolaser.estimation.certainty import EVEN
from robolaser.estimation.identifiability import UNIFORM
from robolaser.estimation.noise_estimate import NOISE_CONTRADICTED_SIGMA
from robolaser.model.effects.effect import CandidateEffect
from robolaser.model.sensors.placements import SIX


def explainable(fit: Fit, effects: Sequence[CandidateEffect], *, poses_scatter: bool) -> Array:
    """Directions of the plain residuals that parameters and effects within their bounds explain, (K, n).

    Directions that need parameters far beyond their bounds are excluded. With more than half as many parameters as the
    poses have motions, effects would explain anything: then only the sensor's parameters count, and the one effect, if
    any, that explains the whole gap.

    Args:
        fit: The model without effects, with row noise only.
        effects: All candidate effects, nonlinear parameters at their first values.
        poses_scatter: Whether the scatter of whole poses is estimated, not only that of rows.
    """
    e, amplitudes = fit.at.white, [one.effect.amplitudes() for one in effects]
    independent = min(len(e), len(SIX) * len(fit.poses)) if poses_scatter else len(e)
    if EVEN * independent < fit.at.slopes.shape[1] + sum(map(len, amplitudes)):
        return fit.noise.correlate(_beside_cause(fit, effects).at.slopes.T).T
    columns, parts = Columns(), [fit.at.slopes * UNIFORM]
    for one, own in zip(effects, amplitudes, strict=True):
        widths = 2.0 * UNIFORM * np.array([amplitude.bound for amplitude in own])
        grid = one.effect.grid(fit.model.dataset, one.where)[:1]
        parts.append(columns.by_effect(fit, one, grid) * (widths / prior_scales(one)))
    U, s, _ = np.linalg.svd(np.hstack(parts), full_matrices=False)
    along = U.T @ e
    plausible = np.abs(along) <= NOISE_CONTRADICTED_SIGMA * s
    rest, variance = float(e @ e - along @ along), float(e @ e) / len(e)
    for _ in range(MOST_STEPS):
        free = plausible * s**2 / (s**2 + variance)
        left = rest + (((1.0 - free) * along) ** 2).sum()
        variance = float(left) / (len(e) - float(free.sum()))
    return fit.noise.correlate((U * s)[:, plausible & (s**2 > variance)].T).T


def _beside_cause(fit: Fit, effects: Sequence[CandidateEffect]) -> Fit:
    """The fit with the one effect that explains the whole gap, if any: scatter does not imitate such an effect."""
    refits = Refits(fit, effects)
    tests = refits.score_tests(fit)[:1]
    above_noise = fit.chi2 - fit.freedoms
    if not tests or tests[0].gain <= max(tests[0].penalty, (1.0 - OPEN_SHARE) * above_noise):
        return fit
    return refits.refit(fit, tests)


def explained(fit: Fit, *, smooth: bool) -> Array:
    """Directions of the plain residuals that a model's free parameters explain, (K, n).

    Directions that known distances and priors determine more than the data are excluded: an arm that shrinks with all
    its sockets would leave no residuals. Smooth functions at sites with evidence in the residuals may be included.
    """
    own = fit.at.Q[: len(fit.at.white)]
    shares, turned = np.linalg.eigh(own.T @ own)
    parts = [own @ turned[:, shares > EVEN]]
    if smooth:
        parts.append(smooth_remainder(fit))
    return fit.noise.correlate(np.hstack(parts).T).T
