"""How sure it is that an effect is the cause: what else could stand in its place."""

from dataclasses import dataclass
from typing import final

import numpy as np

from robolaser.diagnosis.fitted import Fitted
from robolaser.diagnosis.selection import Search
from robolaser.diagnosis.verdict import INDISTINGUISHABLE, PRIOR_NONE, PRIOR_UNKNOWN
from robolaser.diagnosis.where import explained
from robolaser.effects.effect import Suspect

TRIED = 10
"""Rivals that are fitted in an effect's place."""


@final
@dataclass(frozen=True)
class Stand:
    """An effect against all that could stand in its place.

    Attributes:
        suspect: The effect.
        probability: Of it.
        unknown: Probability that something unknown explains what it does, with no need of it.
        without: The final model without it, fitted.
        rivals: Those that these poses cannot tell from it, nearest first, and what each leaves.
    """

    suspect: Suspect
    probability: float
    unknown: float
    without: Fitted
    rivals: tuple[Fitted, ...]


def stands(search: Search, final: Fitted, spread: float) -> list[Stand]:
    """Judge each effect of the final model."""
    return [_stand(search, final, suspect, spread) for suspect in final.suspects]


def _stand(search: Search, final: Fitted, suspect: Suspect, spread: float) -> Stand:
    without = search.fit(final, removed=suspect)
    lost = without.misfit - final.misfit
    offered = [s for s in search.signatures(without) if s.suspect != suspect]
    near = [s for s in sorted(offered, key=lambda s: -s.gain)[:TRIED] if s.gain > 0.5 * lost]
    others = [search.fit(without, [s]) for s in near]
    others = [fit for fit in others if suspect not in fit.suspects]
    costs = np.array([search.cost(fit, spread) for fit in (final, *others)])
    unknown = search.cost(without, spread) - explained(without) / spread + PRIOR_UNKNOWN
    nothing = search.cost(without, spread) + PRIOR_NONE
    own = search.cost(final, spread) - explained(final) / spread
    costs = np.concatenate([costs, [nothing]])
    weights = np.exp(-0.5 * (costs - costs.min()))
    strange = float(1.0 / (1.0 + np.exp(np.clip(0.5 * (unknown - own), -700.0, 700.0))))
    probability = float(weights[0] / weights.sum()) * (1.0 - strange)
    close = [fit for fit in others if (fit.misfit - final.misfit) / spread < INDISTINGUISHABLE]
    return Stand(suspect, probability, strange, without, tuple(sorted(close, key=lambda fit: search.cost(fit, spread))))


def rival(stand: Stand, final: Fitted) -> list[Suspect]:
    """The effects that stand in its place in each of its rivals."""
    held = set(final.suspects)
    return [next(s for s in fit.suspects if s not in held) for fit in stand.rivals]
