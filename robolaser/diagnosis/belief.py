"""Which of the effects that explain the gap are believed, now that something unknown may explain it too."""

from collections.abc import Sequence

from robolaser.diagnosis.fitted import Fitted
from robolaser.diagnosis.rivals import Stand, echoes, stand
from robolaser.diagnosis.selection import Search
from robolaser.diagnosis.verdict import BELIEVED, dispersion
from robolaser.diagnosis.where import Lies, where


def believed(search: Search, final: Fitted) -> tuple[Fitted, list[Stand], list[Lies]]:
    """Take back effects that something unknown explains better, and those that only echo the form of a larger one.

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
            doubtful = echoes(standing, final)
        if not doubtful:
            return final, standing, left
        for suspect in doubtful[: max(1, len(doubtful) // 2)]:
            final = search.fit(final, removed=suspect)
        left = where(final)


def rest_of(search: Search, final: Fitted, standing: Sequence[Stand], left: list[Lies]) -> list[Lies]:
    """Where lies what is left by those effects that are rather believed than not."""
    doubted = [one.suspect for one in standing if one.probability < BELIEVED]
    for suspect in doubted:
        final = search.fit(final, removed=suspect)
    return where(final) if doubted else left
