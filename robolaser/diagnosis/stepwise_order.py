"""Greedy order of effects in the linear model: each explains most beside those before it."""

from collections.abc import Sequence
from itertools import pairwise

import numpy as np

from robolaser.arrays import Array, Ints
from robolaser.diagnosis.fit import NEGLIGIBLE
from robolaser.diagnosis.refits import penalty
from robolaser.diagnosis.score_tests import ScoreTest


def stepwise_order(tests: Sequence[ScoreTest], most: int, least: float = -np.inf) -> list[int]:
    """Order effects by the chi-squared that each explains beyond its penalty, beside those before it.

    Args:
        tests: Score tests of the effects, all against one model.
        most: Largest number of effects to return.
        least: Chi-squared beyond its penalty that each must explain.

    Returns:
        Indices of the tests.
    """
    if not tests:
        return []
    G, spans = _normal_equations(tests)
    prices = np.array([penalty(test) for test in tests])
    order: list[int] = []
    for _ in range(min(most, len(tests))):
        net = _gains(G, spans) - prices
        net[order] = -np.inf
        best = int(net.argmax())
        if net[best] < least:
            break
        order.append(best)
        span = spans[best]
        G = G - G[:, span] @ _inverse(G, span) @ G[span]
    return order


def _normal_equations(tests: Sequence[ScoreTest]) -> tuple[Array, list[Ints]]:
    """Products of all effects' columns, in units of their lengths, and the residuals; and the rows of each effect."""
    columns = np.hstack([test.columns for test in tests])
    squares = (np.hstack([test.white for test in tests]) ** 2).sum(axis=0)
    tall = np.column_stack([columns / np.sqrt(np.maximum(squares, np.finfo(float).tiny)), tests[0].against.at.r])
    ends = np.cumsum([0] + [test.columns.shape[1] for test in tests])
    return tall.T @ tall, [np.arange(start, end) for start, end in pairwise(ends)]


def _gains(G: Array, spans: Sequence[Ints]) -> Array:
    """Chi-squared that each effect explains, (n,), computed together for equal numbers of columns."""
    gains, widths = np.zeros(len(spans)), np.array([len(span) for span in spans])
    for width in np.unique(widths):
        same_width = np.flatnonzero(widths == width)
        own = np.stack([spans[i] for i in same_width.tolist()])
        squares, vectors = np.linalg.eigh(G[own[:, :, None], own[:, None]])
        along = (np.swapaxes(vectors, 1, 2) @ G[own, -1][..., None])[..., 0]
        seen = squares > NEGLIGIBLE
        gains[same_width] = np.divide(along**2, squares, out=np.zeros_like(squares), where=seen).sum(axis=1)
    return gains


def _inverse(G: Array, span: Ints) -> Array:
    values, vectors = np.linalg.eigh(G[np.ix_(span, span)])
    seen = values > NEGLIGIBLE
    found: Array = (vectors[:, seen] / values[seen]) @ vectors[:, seen].T
    return found
