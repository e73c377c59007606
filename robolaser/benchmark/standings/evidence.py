"""All that is measured of a family of problems in one measure, before anybody judges."""

from dataclasses import dataclass
from typing import final

import numpy as np

from robolaser.arrays import Array, Ints
from robolaser.benchmark.results_array import HEADLINE, Tally
from robolaser.benchmark.standings.table import Measure
from robolaser.benchmark.statistics import difference, running_time
from robolaser.benchmark.statistics.bounded import Bounded
from robolaser.benchmark.statistics.outcome import outcomes
from robolaser.benchmark.statistics.success import successes
from robolaser.benchmark.statistics.superiority import superiority


@final
@dataclass(frozen=True, eq=False)
class Evidence:
    """Over problems p, algorithms a, seeds s and targets t.

    Attributes:
        measure: What runs are paid in.
        tally: Of all runs.
        prices: To each target, (p, a, s, t).
        spent: By whole runs, (p, a, s).
        headline: Which target ranks.
        runs: That there are, (p, a).
        reached: Runs that reached the headline target, (p, a).
        outcomes: Places of runs on their problem, (p, a, s).
        expected: Running times to each target, (p, a, t).
        samples: The same to the headline target in bootstrap samples, (p, a, b).
        ratios: Second over first, (p, a, a).
        superiority: Of first over second, (p, a, a).
        p: Of each pair on each problem, (p, a, a).
        p_adjusted: For all pairs on all problems.
    """

    measure: Measure
    tally: Tally
    prices: Array
    spent: Array
    headline: int
    runs: Ints
    reached: Ints
    outcomes: Array
    expected: Bounded
    samples: Array
    ratios: Bounded
    superiority: Bounded
    p: Array
    p_adjusted: Array

    @classmethod
    def of(cls, tally: Tally, measure: Measure, drawn: Ints) -> "Evidence":
        """Measure, with intervals from these bootstrap samples (p, b, s)."""
        prices, spent = (
            (tally.evaluations, tally.spent_evaluations) if measure == "evaluations" else (tally.seconds, tally.spent_s)
        )
        at = tally.target(HEADLINE)
        reached, runs = successes(prices[..., at])
        expected, samples = running_time.expected(prices, spent), running_time.resampled(prices, spent, drawn)
        came = outcomes(prices[..., at], tally.final)
        p = difference.rank_sum(came)
        each_target = np.broadcast_to(runs[..., None], expected.shape)
        return cls(
            measure=measure,
            tally=tally,
            prices=prices,
            spent=spent,
            headline=at,
            runs=runs,
            reached=reached,
            outcomes=came,
            expected=running_time.bounds(expected, samples, each_target),
            samples=samples[:, :, at],
            ratios=running_time.ratios(samples[:, :, at], expected[..., at], runs),
            superiority=superiority(came),
            p=p,
            p_adjusted=difference.holm_pairs(p),
        )
