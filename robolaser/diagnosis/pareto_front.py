"""The gap against the number of effects: what each further effect gains on held-out poses."""

from collections.abc import Sequence
from itertools import pairwise

import numpy as np

from robolaser.arrays import Array, Ints
from robolaser.diagnosis.fit import Fit
from robolaser.diagnosis.held_out_gap import HeldOut
from robolaser.diagnosis.refits import Announce, Refits, penalty
from robolaser.diagnosis.result import ParetoPoint
from robolaser.diagnosis.score_tests import ScoreTest

LEADERS = 12
"""Effects of which sets are made, so at most 4096 sets."""
FURTHER, AT_LEAST = 1, 2
"""Effects beyond those of the diagnosis, up to which sets are fitted, and the least size of the largest of them."""
SEEN = 1e-12
"""Share of the squared length of an effect's column, below which it is a combination of those taken before."""


def pareto_front(
    refits: Refits, nested: Sequence[Fit], held_out: HeldOut, progress: Announce = lambda what: None
) -> tuple[ParetoPoint, ...]:
    """The sets of effects than which none with as few effects has a smaller held-out gap, from none on.

    All sets of the most promising effects are compared by chi-squared of the model as linear around the fit without
    effects, exactly; the best of each size is fitted, and judged by the same held-out error as every other gap of
    the diagnosis. So a set has one gap wherever it is shown.

    Args:
        refits: Fits sets of effects.
        nested: Fits of the chosen effects, added one by one; the model without effects first.
        held_out: Errors on held-out poses.
        progress: Is called with what is being compared.

    Returns:
        Sets by their number of effects, each with a smaller gap than the one before.
    """
    tests = refits.score_tests(refits.start)
    leaders = [tests[i] for i in stepwise_order(tests)]
    most = max(AT_LEAST, len(nested) - 1 + FURTHER)
    fits = list(nested)
    for some in best_subsets(leaders, most):
        progress(f"comparing sets of {len(some)} effects")
        fits.append(refits.of(refits.start, some))
    gaps = np.array([held_out.gap(fit) for fit in fits])
    counts = np.array([len(fit.effects) for fit in fits], dtype=np.int64)
    return tuple(ParetoPoint(fits[i].effects, float(gaps[i])) for i in undominated(counts, gaps))


def best_subsets(tests: Sequence[ScoreTest], most: int) -> list[tuple[ScoreTest, ...]]:
    """Of each size, the set of effects that explains the most chi-squared as far as the model is linear."""
    found: list[tuple[ScoreTest, ...]] = []
    for size, sets in _explained(tests, most).items():
        if size:
            found.append(tuple(tests[i] for i in max(sets, key=sets.__getitem__)))
    return found


def _explained(tests: Sequence[ScoreTest], most: int) -> dict[int, dict[tuple[int, ...], float]]:
    """Chi-squared that each set of up to so many effects explains, by size and members.

    Effects are taken in their order; what a further effect explains follows from the normal equations from which those
    before it are eliminated.
    """
    found: dict[int, dict[tuple[int, ...], float]] = {size: {} for size in range(min(most, len(tests)) + 1)}

    def grow(taken: tuple[int, ...], explained: float, G: Array, spans: Sequence[Ints]) -> None:
        found[len(taken)][taken] = explained
        if len(taken) == most:
            return
        for k, span in enumerate(spans):
            inverse = _inverse(G, span)
            more = explained + float(G[span, -1] @ inverse @ G[span, -1])
            rest = np.arange(span[-1] + 1, len(G))
            part = G[np.ix_(span, rest)]
            less = G[np.ix_(rest, rest)] - part.T @ inverse @ part
            grow((*taken, len(tests) - len(spans) + k), more, less, [own - rest[0] for own in spans[k + 1 :]])

    if tests:
        grow((), 0.0, *_normal_equations(tests))
    return found


def stepwise_order(tests: Sequence[ScoreTest], most: int = LEADERS, least: float = -np.inf) -> list[int]:
    """The order in which effects are taken, each the one that explains most for its penalty beside those before it.

    Args:
        tests: Of the effects, all against one model.
        most: Effects to be taken.
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


def undominated(counts: Ints, gaps: Array) -> list[int]:
    """Indices of those than which none with as few effects has a smaller gap, by their number of effects."""
    front: list[int] = []
    for i in np.lexsort((gaps, counts)).tolist():
        if not front or gaps[i] < gaps[front[-1]]:
            front.append(i)
    return front


def _normal_equations(tests: Sequence[ScoreTest]) -> tuple[Array, list[Ints]]:
    """Products of all effects' columns, in units of their lengths, and the residuals; which rows are whose."""
    columns = np.hstack([test.columns for test in tests])
    squares = (np.hstack([test.white for test in tests]) ** 2).sum(axis=0)
    tall = np.column_stack([columns / np.sqrt(np.maximum(squares, np.finfo(float).tiny)), tests[0].against.at.r])
    ends = np.cumsum([0] + [test.columns.shape[1] for test in tests])
    return tall.T @ tall, [np.arange(start, end) for start, end in pairwise(ends)]


def _gains(G: Array, spans: Sequence[Ints]) -> Array:
    """Chi-squared that each effect explains, those with as many columns at once, (n,)."""
    gains, widths = np.zeros(len(spans)), np.array([len(span) for span in spans])
    for width in np.unique(widths):
        alike = np.flatnonzero(widths == width)
        own = np.stack([spans[i] for i in alike.tolist()])
        squares, vectors = np.linalg.eigh(G[own[:, :, None], own[:, None]])
        along = (np.swapaxes(vectors, 1, 2) @ G[own, -1][..., None])[..., 0]
        seen = squares > SEEN
        gains[alike] = np.divide(along**2, squares, out=np.zeros_like(squares), where=seen).sum(axis=1)
    return gains


def _inverse(G: Array, span: Ints) -> Array:
    values, vectors = np.linalg.eigh(G[np.ix_(span, span)])
    seen = values > SEEN
    found: Array = (vectors[:, seen] / values[seen]) @ vectors[:, seen].T
    return found
