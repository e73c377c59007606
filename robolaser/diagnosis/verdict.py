"""The judge: every threshold of the diagnosis, and what follows from the evidence."""

from collections.abc import Sequence
from typing import TYPE_CHECKING

import numpy as np

from robolaser.diagnosis.averaging import size
from robolaser.model.effects.effect import CandidateEffect

if TYPE_CHECKING:
    from robolaser.diagnosis.localization import Localization
    from robolaser.diagnosis.penalized_fit import Fitted
    from robolaser.diagnosis.result import Gap

ENTRY = 16.0
"""Squared whitened misfit that any effect must explain: with a hundred candidates chance does so once in 200 times."""
PER_NUMBER = 4.5
"""The same for each of its numbers: chance gains 1 for each, and the largest of many chances more."""
FEW, PER_FURTHER = 6, 1.5
"""Numbers beyond the sixth cost less: that all of many get more than their share is ever less likely."""
POSE_FREEDOMS = 4.0
"""What a pose as a whole can be off by, independently: errors that the model lacks rarely use all six freedoms."""


def price(candidate_effect: CandidateEffect, tried: int) -> float:
    """What an effect must gain in squared whitened misfit, its shapes chosen out of so many."""
    numbers = len(candidate_effect.kind.declared()) + len(candidate_effect.kind.shapes())
    further = max(0, numbers - FEW)
    return ENTRY + PER_NUMBER * (numbers - further) + PER_FURTHER * further + 2.0 * float(np.log(tried))


def dispersion(fitted: "Fitted") -> float:
    """How much more the residuals of whole poses scatter than noise would have them, at least 1.

    What a model leaves unexplained makes every further effect look significant: gains are judged by it.
    """
    freedoms = max(1, len(fitted.r) - len(fitted.x))
    excess = fitted.misfit - freedoms - 2.0 * np.sqrt(2.0 * freedoms)
    poses = len(np.unique(fitted.problem.model.dataset.points.pose))
    return 1.0 + max(0.0, float(excess)) / (POSE_FREEDOMS * poses)


GROSS = 5.5
"""Distance of a row, in standard deviations, beyond which it is a gross error: noise puts one in a million there."""

SITE_SIGNIFICANT = 18.0
"""Twice the log of a likelihood ratio, from which on a gap is said to lie at a site: with a hundred coordinates asked,
chance gets there once in 500 times."""

PRIOR_UNKNOWN = 12.0
"""What it costs, in squared whitened misfit, to say that the cause is none of the library's: it is so in fewer than
one cell in a hundred that the library explains as well."""
INDISTINGUISHABLE = 20.0
"""Squared whitened misfit, in units of the dispersion, below which two effects are not told apart: at 14 chance
exchanges them three times in a hundred, and what is seen of it scatters by 7."""
ECHO = 0.05
"""Share of what a larger effect explains, below which an effect that others could replace is that one's echo."""
ECHOED = 3
"""Places where another effect would do as well, from which on it does not seem to have a place of its own."""
AT_FLOOR = 1.1
"""Held-out gap over the noise floor, up to which what is left may be an effect's form and need no further cause."""
DOUBT = 20.0
"""How fast an effect loses credit with what is left unexplained: a twentieth of what it explains halves it."""
EXPLAINED = 0.02
"""Share of what the effects explained, up to which the rest counts as their form being a little different."""
SCATTER = 6.0
"""Standard deviations by which the squared misfit may exceed its expectation: the noise is known to a few per cent."""
STRANGE = 2.0
"""Factor of the noise that rows show, by which whole poses may scatter beyond all that the effects explain."""
DETECTED = 1.28
"""Standard deviations above the threshold at which an effect is found nine times in ten."""

FEWEST_POSES = 5
"""Poses with points, below which no effect is judged: what is left fits anything."""
CREDIBLE = 0.1
"""Probability that nothing unknown explains what an effect does, below which it is not worth a person's time."""
BELIEVED = 0.5
"""Probability that something unknown explains what an effect does, beyond which the effect is not named."""


def judge(start: "Fitted", final: "Fitted", left: Sequence["Localization"], gap: "Gap") -> str:
    """`no_gap`, `explained` or `unexplained`.

    Args:
        start: The model without effects.
        final: The model with those that were found.
        left: Places where something is left, by the likelihood of a function there.
        gap: How far the gap shrinks.
    """
    freedoms = max(1, len(final.r) - len(final.x))
    closed = start.misfit - final.misfit
    rest = max(sum(lies.likelihood_ratio for lies in left), final.misfit - freedoms - SCATTER * np.sqrt(2.0 * freedoms))
    if size(final.problem.noise) > STRANGE * gap.noise_floor_m:
        return "unexplained"
    if not left and rest <= 0:
        return "explained" if final.effects else "no_gap"
    if final.effects and rest <= EXPLAINED * closed and gap.after_m <= AT_FLOOR * gap.noise_floor_m:
        return "explained"
    return "unexplained"
