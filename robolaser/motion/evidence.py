"""The information in correlated rows: their number of independent values, and the score of a model."""

from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from typing import final

import numpy as np

from robolaser.arrays import Array, Ints
from robolaser.motion.effect import At

FEWEST_VALUES = 2.0
IDEAL_SHARE = 0.01  # share of an ideal arm's error that is left by the form of its model. A judgement
BY_CHANCE = 1e-3  # level of significance: noise alone is rejected below it. A judgement


@final
@dataclass(frozen=True, eq=False)
class Fitted:
    """A fitted model of some rows: an ideal arm and effects."""

    effects: tuple[At, ...]
    numbers: tuple[Array, ...]  # by effect
    shapes: tuple[int, ...]  # index of each effect's shape
    score: float  # twice the negative logarithm of the evidence, up to a constant; less is better
    squares: Array  # sum of squared residuals of each joint, (j,)
    exact: float = np.inf  # the score if the models' form were exact, where known

    @property
    def names(self) -> frozenset[str]:
        """Its effects with their locations."""
        return names_of(self.effects)

    def worse_than(self, other: "Fitted") -> float:
        """Difference of the scores, at most 0 if only the error of the models' form hides that the other is worse."""
        by = self.score - other.score
        exactly = self.exact - other.exact if np.isfinite(other.exact) else by
        return min(by, 0.0) if exactly < 0.0 else max(by, exactly)


def names_of(effects: Iterable[At]) -> frozenset[str]:
    """The effects' names, in any order."""
    return frozenset(map(str, effects))


def of_each(effects: Sequence[At], values: Array) -> tuple[Array, ...]:
    """Concatenated numbers, split by effect."""
    ends = np.cumsum([len(one.effect.numbers) for one in effects])[:-1].astype(int)
    return tuple(np.split(values, ends)) if effects else ()


def independent_values(residual: Array, run: Ints) -> float:
    """Effective sample size of correlated residuals (n,) in runs (n,).

    n / (1 + 2 Σ ρ), summed up to the first correlation that is not positive (Geyer 1992, Statistical Science 7), of
    deviations from each run's mean: a constant of a run hides nothing that happens in it.
    """
    parts = [residual[run == number] for number in np.unique(run)]
    parts = [part - part.mean() for part in parts]
    longest = max(map(len, parts))
    size = 2 ** int(np.ceil(np.log2(2 * longest)))
    products = np.zeros(size)
    pairs = np.zeros(longest)
    for part in parts:
        spectrum = np.fft.rfft(part, size)
        products += np.fft.irfft(np.abs(spectrum) ** 2, size)
        pairs[: len(part)] += np.arange(len(part), 0, -1)
    if products[0] <= 0.0:
        return float(len(residual))
    correlation = (products[:longest] / np.maximum(pairs, 1.0)) / (products[0] / pairs[0])
    ends = np.flatnonzero(correlation <= 0.0)
    upto = int(ends[0]) if len(ends) else longest
    values = len(residual) / (1.0 + 2.0 * float(correlation[1:upto].sum()))
    return float(np.clip(values, FEWEST_VALUES, len(residual)))


def score_of(squares: Array, rows: Array, independent: Array, form: Array, numbers: float) -> float:
    """BIC of a model: n log(mean square) over joints, and log n for each number (Schwarz 1978).

    Of each joint, (j,), the sum of squared residuals, the count and effective sample size of its rows, and the error of
    its model's form: less is no evidence.
    """
    there = rows > 0
    mean = np.maximum(squares[there] / rows[there], np.maximum(form[there] ** 2, 1e-24))
    return float(independent[there] @ np.log(mean) + numbers * np.log(max(independent.sum(), np.e)))
