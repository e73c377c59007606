"""Which of the effects that explain the gap are believed, now that something unknown may explain it too."""

from collections.abc import Sequence

import numpy as np

from robolaser.diagnosis.held_out_gap import Unseen
from robolaser.diagnosis.localization import Localization, where
from robolaser.diagnosis.penalized_fit import Fitted
from robolaser.diagnosis.probabilities import Stand, echoes, stand
from robolaser.diagnosis.selection import Search
from robolaser.diagnosis.verdict import BELIEVED, CREDIBLE, dispersion
from robolaser.model.effects.effect import CandidateEffect


def believed(search: Search, final: Fitted, unseen: Unseen) -> tuple[Fitted, list[Stand], list[Localization]]:
    """Take back effects that something unknown explains better, and those that only echo the form of a larger one.

    Also those without which poses that were held out are predicted as well.

    Args:
        search: Fits sets of effects.
        final: The set that explains the most for its price.
        unseen: Errors on poses held out.

    Returns:
        The model that is left, how each of its effects stands, and where its residuals still lie.
    """
    final = _helpful(search, final, unseen)
    left = where(final)
    while True:
        spread = dispersion(final)
        strange = {
            candidate_effect: search.strange(final, search.fit(final, removed=candidate_effect)) if left else 0.0
            for candidate_effect in final.effects
        }
        doubtful = sorted(
            (candidate_effect for candidate_effect in strange if strange[candidate_effect] > BELIEVED),
            key=lambda s: -strange[s],
        )
        if not doubtful:
            rest = sum(lies.likelihood_ratio for lies in left)
            standing = [
                stand(search, final, candidate_effect, spread, strange[candidate_effect], rest)
                for candidate_effect in final.effects
            ]
            doubtful = echoes(standing, final) or _incredible(standing, final)
        if not doubtful:
            helpful = _helpful(search, final, unseen)
            if helpful is final:
                return final, standing, left
            final, doubtful = helpful, []
        for candidate_effect in doubtful[: -(-len(doubtful) // 2)]:
            final = search.fit(final, removed=candidate_effect)
        left = where(final)


def _incredible(standing: Sequence[Stand], final: Fitted) -> list[CandidateEffect]:
    """Effects that next to nothing speaks for beside what is left, the least credible first.

    Not of trackers and sockets: there a whole arm's geometry counts, each part of which explains little.
    """
    if final.problem.model.dataset.kind != "stripe":
        return []
    return [one.candidate_effect for one in sorted(standing, key=lambda one: one.credit) if one.credit < CREDIBLE]


def _helpful(search: Search, final: Fitted, unseen: Unseen) -> Fitted:
    """Take back effects without which held-out poses are predicted as well, one by one, the least helpful first."""
    gap = unseen.gap(final)
    while final.effects:
        less = [search.fit(final, removed=candidate_effect) for candidate_effect in final.effects]
        gaps = [unseen.gap(fit) for fit in less]
        best = int(np.argmin(gaps))
        if gaps[best] > gap:
            break
        final, gap = less[best], gaps[best]
    return final


def rest_of(search: Search, final: Fitted, standing: Sequence[Stand], left: list[Localization]) -> list[Localization]:
    """Where lies what is left by those effects that are rather believed than not."""
    doubted = [one.candidate_effect for one in standing if one.probability < BELIEVED]
    for candidate_effect in doubted:
        final = search.fit(final, removed=candidate_effect)
    return where(final) if doubted else left
