"""The judge: every threshold of the diagnosis, and what follows from the evidence."""

from typing import TYPE_CHECKING

import numpy as np

from robolaser.effects.effect import Suspect

if TYPE_CHECKING:
    from robolaser.diagnosis.fitted import Fitted

ENTRY = 16.0
"""Squared whitened misfit that any effect must explain: with a hundred candidates chance does so once in 200 times."""
PER_NUMBER = 3.5
"""The same for each of its numbers: chance gains 1 for each, and the largest of many chances more."""
POSE_FREEDOMS = 4.0
"""What a pose as a whole can be off by, independently: errors that the model lacks rarely use all six freedoms."""


def price(suspect: Suspect, tried: int) -> float:
    """What an effect must gain in squared whitened misfit, its shapes chosen out of so many."""
    numbers = len(suspect.kind.declared()) + len(suspect.kind.shapes())
    return ENTRY + PER_NUMBER * numbers + 2.0 * float(np.log(tried))


def dispersion(fitted: "Fitted") -> float:
    """How much more the residuals of whole poses scatter than noise would have them, at least 1.

    What a model leaves unexplained makes every further effect look significant: gains are judged by it.
    """
    freedoms = len(fitted.r) - len(fitted.x)
    excess = fitted.misfit - freedoms - 2.0 * np.sqrt(2.0 * freedoms)
    poses = len(np.unique(fitted.problem.model.dataset.points.pose))
    return 1.0 + max(0.0, float(excess)) / (POSE_FREEDOMS * poses)


GROSS = 5.5
"""Distance of a row, in standard deviations, beyond which it is a gross error: noise puts one in a million there."""

SITE_SIGNIFICANT = 18.0
"""Twice the log of a likelihood ratio, from which on a gap is said to lie at a site: with a hundred coordinates asked,
chance gets there once in 500 times."""
