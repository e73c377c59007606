"""The geometry of a whole arm as one effect: all joint placements, each penalised by its usual size."""

from collections.abc import Sequence

import numpy as np

from robolaser.arrays import Array
from robolaser.diagnosis.profile_likelihood import SIZES
from robolaser.diagnosis.thresholds import LARGEST_USUAL, PLACEMENTS_OF_AN_ARM
from robolaser.model.effects.effect import CandidateEffect
from robolaser.model.effects.link_geometry import LinkGeometry


def placements_of_arm(effects: Sequence[CandidateEffect]) -> tuple[CandidateEffect, ...]:
    """Return the link placements among effects if they are enough to be the geometry of the whole arm, else none.

    Each of their parameters is then penalised by its usual size: together they give the fitting arm that is nearest to
    the nominal one, even if the data do not determine some combination of them.
    """
    placements = tuple(one for one in effects if one.effect is LinkGeometry)
    return placements if len(placements) >= PLACEMENTS_OF_AN_ARM else ()


def marginal_cost(x: Array, covariance: Array, prior: Array) -> float:
    """Cost of parameters with a Gaussian prior of unknown size, by the marginal likelihood, in chi-squared.

    Freedom costs the logarithm of the ratio of prior to posterior variance (MacKay 1992, Neural Computation 4), for the
    prior size with the largest likelihood. Distances from that prior replace those from the prior of size 1, which are
    in a fit's chi-squared.

    Args:
        x: The parameters at the optimum, (p,); nominally zero.
        covariance: Their covariance there, the prior included, (p, p).
        prior: Their standard deviations in the prior of size 1, (p,).
    """
    information = _inverse(covariance / np.outer(prior, prior))
    gradient = information @ (x / prior)
    of_data, V = np.linalg.eigh(information - np.eye(len(x)))
    of_data, along = np.maximum(of_data, 0.0), (V.T @ gradient) ** 2
    variances = SIZES[SIZES <= LARGEST_USUAL, None] ** 2
    freedom = np.log1p(variances * of_data).sum(axis=1)
    explained = (along * variances / (1.0 + variances * of_data)).sum(axis=1)
    at_size_one = float((along / (1.0 + of_data)).sum())
    return float((freedom - explained).min()) + at_size_one


def _inverse(covariance: Array) -> Array:
    """The inverse; variances that rounding makes zero, as of fits far from any real cell, are set to the resolution."""
    try:
        return np.asarray(np.linalg.inv(covariance))
    except np.linalg.LinAlgError:
        variances, V = np.linalg.eigh(covariance)
        return np.asarray((V / np.maximum(variances, np.finfo(float).eps * max(1.0, variances[-1]))) @ V.T)
