"""What the whole library of effects could explain at once: errors that remain are the cell's own scatter."""

from collections.abc import Sequence

import numpy as np

from robolaser.arrays import Array
from robolaser.diagnosis.penalized_fit import Fit
from robolaser.diagnosis.score_tests import derivatives, prior_scales
from robolaser.estimation.identifiability import UNIFORM
from robolaser.model.effects.effect import CandidateEffect

ROUNDS = 30
"""Of scatter given what is explained, and what is explained given the scatter."""
ENOUGH = 2
"""Residuals for each number, below which nothing is asked of the effects."""
PLAUSIBLE = 4.0
"""Amplitude of a direction, in standard deviations of what its numbers may be, beyond which it explains nothing."""


def explicable(fitted: Fit, candidate_effects: Sequence[CandidateEffect]) -> Array:
    """Directions of the plain residuals that parameters and effects of plausible sizes explain, (3m, k).

    A direction that would need numbers beyond their bounds to show among what is left explains nothing: a robot
    shrunk to a point fits every socket. Where the effects have nearly as many numbers as there are residuals, they
    would explain anything: then the parameters alone count.

    Args:
        fitted: The model without effects.
        candidate_effects: All effects that may be at work; shapes have their first values.
    """
    parts = [fitted.jacobian * fitted.problem.prior]
    for one in candidate_effects:
        bounds = np.array([bound for _, _, bound, _ in one.effect.amplitudes()])
        columns = derivatives(fitted, one, one.effect.grid(fitted.problem.model.dataset, one.where)[:1])
        parts.append(columns.reshape(len(columns), -1).T * (2.0 * UNIFORM * bounds / prior_scales(one)))
    every = np.hstack(parts)
    if len(every) < ENOUGH * every.shape[1]:
        return fitted.jacobian
    U, s, _ = np.linalg.svd(every, full_matrices=False)
    e = fitted.residuals.reshape(-1)
    along = U.T @ e
    plausible = np.abs(along) <= PLAUSIBLE * s
    rest, variance = float(e @ e - along @ along), float(e @ e) / len(e)
    for _ in range(ROUNDS):
        free = plausible * s**2 / (s**2 + variance)
        left = rest + (((1.0 - free) * along) ** 2).sum()
        variance = float(left) / (len(e) - float(free.sum()))
    found: Array = U[:, plausible & (s**2 > variance)]
    return found
