"""Which of the effects that explain the gap are believed, now that something unknown may explain it too."""

from collections.abc import Sequence

from robolaser.arrays import Ints
from robolaser.diagnosis.fitted import Fitted
from robolaser.diagnosis.gap import held_out, rms
from robolaser.diagnosis.rivals import Stand, echoes, stand
from robolaser.diagnosis.selection import Search
from robolaser.diagnosis.verdict import BELIEVED, dispersion
from robolaser.diagnosis.where import Lies, where
from robolaser.effects.effect import Suspect


def believed(search: Search, final: Fitted, fold: Ints) -> tuple[Fitted, list[Stand], list[Lies]]:
    """Take back effects that something unknown explains better, and those that only echo the form of a larger one.

    Seen by a tracker or by sockets, also those without which poses that were held out are predicted as well.

    Args:
        search: Fits sets of effects.
        final: The set that explains the most for its price.
        fold: The group in which each pose is held out, (n,).

    Returns:
        The model that is left, how each of its effects stands, and where its residuals still lie.
    """
    left = where(final)
    while True:
        spread = dispersion(final)
        strange = {
            suspect: search.strange(final, search.fit(final, removed=suspect)) if left else 0.0
            for suspect in final.suspects
        }
        doubtful = sorted((suspect for suspect in strange if strange[suspect] > BELIEVED), key=lambda s: -strange[s])
        if not doubtful:
            rest = sum(lies.likelihood_ratio for lies in left)
            standing = [stand(search, final, suspect, spread, strange[suspect], rest) for suspect in final.suspects]
            doubtful = echoes(standing, final) or _idle(standing, final, fold)
        if not doubtful:
            return final, standing, left
        for suspect in doubtful[: max(1, len(doubtful) // 2)]:
            final = search.fit(final, removed=suspect)
        left = where(final)


def _idle(standing: Sequence[Stand], final: Fitted, fold: Ints) -> list[Suspect]:
    """Effects without which held-out poses are predicted as well, the least helpful first."""
    if final.problem.model.dataset.kind == "stripe" or not standing:
        return []
    gap = rms(held_out(final, fold))
    without = {one.suspect: rms(held_out(one.without, fold)) for one in standing}
    return sorted((suspect for suspect in without if without[suspect] <= gap), key=without.__getitem__)


def rest_of(search: Search, final: Fitted, standing: Sequence[Stand], left: list[Lies]) -> list[Lies]:
    """Where lies what is left by those effects that are rather believed than not."""
    doubted = [one.suspect for one in standing if one.probability < BELIEVED]
    for suspect in doubted:
        final = search.fit(final, removed=suspect)
    return where(final) if doubted else left
