"""What the whole library of effects could explain at once: what remains is the scatter of whole poses."""

from collections.abc import Sequence

import numpy as np

from robolaser.arrays import Array
from robolaser.diagnosis.fit import Fit
from robolaser.estimation.identifiability import UNIFORM
from robolaser.estimation.linearization import Linearization
from robolaser.model.effects.effect import CandidateEffect

ROUNDS = 30
"""Of the scatter given what is explained, and what is explained given the scatter."""
MIN_RESIDUALS = 2
"""Residuals for each parameter, below which effects are not tried."""
MAX_SIGMA = 4.0
"""Amplitude of a direction, in standard deviations of what its parameters may be, above which it explains nothing."""


def explainable(fit: Fit, effects: Sequence[CandidateEffect]) -> Array:
    """Directions of the plain residuals that parameters and effects within their bounds explain, (K, n).

    A direction that needs parameters far beyond their bounds explains nothing. Where the effects have nearly as many
    parameters as there are residuals, they would explain anything: then the sensor's parameters alone count.

    Args:
        fit: The model without effects.
        effects: All effects that may be at work; nonlinear parameters have their first values.
    """
    plain = Linearization(fit.problem.with_noise(None), fit.x)
    own = plain.slopes / fit.problem.scale
    parts = [plain.slopes * UNIFORM]
    for one in effects:
        bounds = np.array([amplitude.bound for amplitude in one.effect.amplitudes()])
        grid = one.effect.grid(fit.model.dataset, one.where)[:1]
        parts.append(plain.columns(one, grid)[0] * (2.0 * UNIFORM * bounds))
    every = np.hstack(parts)
    if len(every) < MIN_RESIDUALS * every.shape[1]:
        return own
    U, s, _ = np.linalg.svd(every, full_matrices=False)
    e = plain.white
    along = U.T @ e
    plausible = np.abs(along) <= MAX_SIGMA * s
    rest, variance = float(e @ e - along @ along), float(e @ e) / len(e)
    for _ in range(ROUNDS):
        free = plausible * s**2 / (s**2 + variance)
        left = rest + (((1.0 - free) * along) ** 2).sum()
        variance = float(left) / (len(e) - float(free.sum()))
    found: Array = U[:, plausible & (s**2 > variance)]
    return found
