"""Penalties and probabilities of models, as pure functions of numbers."""

import numpy as np
from scipy.special import softmax

from robolaser.arrays import Array
from robolaser.diagnosis.thresholds import (
    CHI2_PER_EFFECT,
    CHI2_PER_FURTHER_PARAMETER,
    CHI2_PER_PARAMETER,
    SMALL_SHARE,
)
from robolaser.model.sensors.placements import SIX


def complexity_penalty(parameters: int, shapes: int) -> float:
    """Chi-squared that an effect must explain to enter the model.

    Args:
        parameters: Number of its linear and nonlinear parameters.
        shapes: Number of shapes, by its nonlinear parameters, that the best was selected from.
    """
    further = max(0, parameters - len(SIX))
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
