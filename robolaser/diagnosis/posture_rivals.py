"""A single function of unknown form that turns several joints: the rival of several effects together.

Cable drag at the wrist looks like a joint's compliance, a rotated link and a sagging bracket. Each of these effects is
needed beside the others, but one unknown function explains as much as all of them.
"""

from collections.abc import Iterable
from dataclasses import dataclass
from typing import final

import numpy as np

from robolaser.diagnosis.fit import Fit
from robolaser.diagnosis.refits import Refits
from robolaser.diagnosis.verdict import posterior_weights
from robolaser.model.effects.effect import CandidateEffect


@final
@dataclass(frozen=True)
class PostureRivals:
    """Models with such a function and subsets of the final model's effects."""

    held: tuple[frozenset[CandidateEffect], ...]  # the effects in each model
    # their probabilities; the remainder to 1 is that of the final model without such a function
    weights: tuple[float, ...]

    @classmethod
    def of(cls, refits: Refits, final: Fit) -> "PostureRivals":
        """Weigh models with all effects, all but one, and ever fewer, removing the least needed first."""
        single = {one: refits.refit(final, removed=one) for one in final.effects}
        models = {frozenset(fit.effects): fit for fit in (final, *single.values())}
        costs = {held: refits.cost_beside_posture_unknown(fit) for held, fit in models.items()}
        reduced, alone = final, refits.cost_by_chi2(final)
        for one in sorted(single, key=lambda one: costs[frozenset(single[one].effects)]):
            reduced = refits.refit(reduced, removed=one)
            costs[frozenset(reduced.effects)] = refits.cost_beside_posture_unknown(reduced)
        weights = posterior_weights(np.array([alone, *costs.values()]))
        return cls(tuple(costs), tuple(weights[1:].tolist()))

    def unmodelled(self, effects: Iterable[CandidateEffect]) -> float:
        """Probability of such a function without any of some effects."""
        excluded = frozenset(effects)
        return float(sum(weight for held, weight in zip(self.held, self.weights, strict=True) if not held & excluded))
