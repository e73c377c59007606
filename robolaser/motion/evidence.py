"""How much rows with memory say: independent values among correlated ones, and the score of a model."""

from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from typing import final

import numpy as np

from robolaser.arrays import Array, Ints
from robolaser.motion.effect import At

FEWEST_VALUES = 2.0
IDEAL_SHARE = 0.01
"""Of the error of an ideal arm, that the form of its model leaves. A judgement."""
BY_CHANCE = 1e-3
"""Probability that noise alone does as much, below which it was not noise. A judgement."""


@final
@dataclass(frozen=True, eq=False)
class Fitted:
    """A model of some rows: what an ideal arm does, and effects."""

    effects: tuple[At, ...]
    numbers: tuple[Array, ...]  # of each effect
    shapes: tuple[int, ...]  # which of its shapes each effect takes
    score: float  # twice the negative logarithm of the evidence, up to a constant; less is better
    squares: Array  # sum of squared residuals of each joint, (j,)

    @property
    def names(self) -> frozenset[str]:
        """Of its effects at their places."""
        return names_of(self.effects)


def names_of(effects: Iterable[At]) -> frozenset[str]:
    """Which effects these are, whatever their order."""
    return frozenset(map(str, effects))


def of_each(effects: Sequence[At], values: Array) -> tuple[Array, ...]:
    """Numbers of effects, one behind the other, parted by effect."""
    ends = np.cumsum([len(one.effect.numbers) for one in effects])[:-1].astype(int)
    return tuple(np.split(values, ends)) if effects else ()


def independent_values(residual: Array, run: Ints) -> float:
    """How many independent values have the information of correlated ones, (n,), in runs (n,).

    n / (1 + 2 Σ ρ), summed up to the first correlation that is not positive (Geyer 1992, Statistical Science 7), of
    what each run has about its mean: what is constant in a run hides nothing that happens in it.
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
    """Of a model with some numbers: n log(mean square) over joints, and log n for each number (Schwarz 1978).

    Args:
        squares: Sum of squared residuals of each joint, (j,).
        rows: How many there are, (j,).
        independent: As how many independent values they count, (j,).
        form: What models of each joint's rows may err by, (j,): less is no evidence.
        numbers: Of the model.
    """
    there = rows > 0
    mean = np.maximum(squares[there] / rows[there], np.maximum(form[there] ** 2, 1e-24))
    return float(independent[there] @ np.log(mean) + numbers * np.log(max(independent.sum(), np.e)))
