"""How sure it is that an effect is the cause: what else could stand in its place."""

from collections.abc import Sequence
from dataclasses import dataclass
from typing import final

import numpy as np

from robolaser.diagnosis.penalized_fit import Fitted
from robolaser.diagnosis.selection import Search
from robolaser.diagnosis.verdict import DOUBT, ECHO, ECHOED, INDISTINGUISHABLE
from robolaser.model.effects.effect import CandidateEffect

TRIED = 10
"""Rivals that are fitted in an effect's place."""
SHARE = 0.5
"""Share of what an effect explains that a rival must promise to be fitted."""


@final
@dataclass(frozen=True)
class Stand:
    """An effect against all that could stand in its place.

    Attributes:
        candidate_effect: The effect.
        probability: Of it.
        credit: Probability that it, and nothing unknown, explains what it does.
        without: The final model without it, fitted.
        alternatives: Those that these poses cannot tell from it, nearest first, and what each leaves.
    """

    candidate_effect: CandidateEffect
    probability: float
    credit: float
    without: Fitted
    alternatives: tuple[Fitted, ...]


def stand(
    search: Search, final: Fitted, candidate_effect: CandidateEffect, spread: float, strange: float, unexplained: float
) -> Stand:
    """Judge an effect of the final model.

    Args:
        search: Fits other sets.
        final: The model.
        candidate_effect: The effect.
        spread: By how much whole poses scatter more than noise.
        strange: Probability of something unknown in its place.
        unexplained: Squared whitened misfit that no effect explains.
    """
    without = search.fit(final, removed=candidate_effect)
    lost = without.misfit - final.misfit
    offered = [s for s in search.signatures(without) if s.candidate_effect != candidate_effect]
    near = [s for s in sorted(offered, key=lambda s: -s.gain)[:TRIED] if s.gain > SHARE * lost]
    others = [search.fit(without, [s]) for s in near]
    costs = np.array([search.cost(fit, spread) for fit in (final, *others, without)])
    weights = np.exp(-0.5 * (costs - costs.min()))
    credit = (1.0 - strange) / (1.0 + DOUBT * unexplained / max(lost, 1e-9))
    probability = float(weights[0] / weights.sum()) * credit
    close = [fit for fit in others if (fit.misfit - final.misfit) / spread < INDISTINGUISHABLE]
    return Stand(
        candidate_effect, probability, credit, without, tuple(sorted(close, key=lambda fit: search.cost(fit, spread)))
    )


def rival(stand: Stand, final: Fitted) -> list[CandidateEffect]:
    """The effects that stand in its place in each of its rivals."""
    held = set(final.effects)
    return [next(s for s in fit.effects if s not in held) for fit in stand.alternatives]


def echoes(standing: Sequence[Stand], final: Fitted) -> list[CandidateEffect]:
    """Effects that explain next to nothing beside another, and that others in several places would explain as well.

    An effect whose true form differs a little from the library's leaves a rest that many explain in part.
    """
    lost = [one.without.misfit - final.misfit for one in standing]
    return [
        one.candidate_effect
        for one, own in sorted(zip(standing, lost, strict=True), key=lambda pair: pair[1])
        if own < ECHO * max(lost)
        and len({place.where for place in rival(one, final)} - {one.candidate_effect.where}) >= ECHOED
    ]
