"""All that is measured on a family of problems, in evaluations or in seconds, before it is ranked."""

from dataclasses import dataclass
from typing import final

import numpy as np

from robolaser.arrays import Array, Ints
from robolaser.benchmark.result_arrays import HEADLINE, ResultArrays
from robolaser.benchmark.standings.table import Measure
from robolaser.benchmark.statistics import difference, running_time
from robolaser.benchmark.statistics.intervals import Intervals
from robolaser.benchmark.statistics.outcome import outcomes
from robolaser.benchmark.statistics.success import successes
from robolaser.benchmark.statistics.superiority import superiority


@final
@dataclass(frozen=True, eq=False)
class Measurements:
    """BudgetExhausted problems p, algorithms a, seeds s and targets t.

    Attributes:
        measure: Evaluations or seconds.
        arrays: Of all runs.
        running_times: To each target, (p, a, s, t).
        totals: Of whole runs, (p, a, s).
        headline: Which target ranks.
        runs: Number of runs, (p, a).
        reached: Number of runs that reached the headline target, (p, a).
        outcomes: Places of runs on their problem, (p, a, s).
        expected: Running times to each target, (p, a, t).
        samples: The same to the headline target in bootstrap samples, (p, a, b).
        ratios: Second over first, (p, a, a).
        superiority: Of first over second, (p, a, a).
        p: Of each pair on each problem, (p, a, a).
        p_adjusted: For all pairs on all problems.
    """

    measure: Measure
    arrays: ResultArrays
    running_times: Array
    totals: Array
    headline: int
    runs: Ints
    reached: Ints
    outcomes: Array
    expected: Intervals
    samples: Array
    ratios: Intervals
    superiority: Intervals
    p: Array
    p_adjusted: Array

    @classmethod
    def of(cls, arrays: ResultArrays, measure: Measure, drawn: Ints) -> "Measurements":
        """Measure, with intervals from these bootstrap samples (p, b, s)."""
        running_times, totals = (
            (arrays.evaluations, arrays.total_evaluations)
            if measure == "evaluations"
            else (arrays.seconds, arrays.total_s)
        )
        at = arrays.target(HEADLINE)
        reached, runs = successes(running_times[..., at])
        expected, samples = (
            running_time.expected(running_times, totals),
            running_time.resampled(running_times, totals, drawn),
        )
        came = outcomes(running_times[..., at], arrays.final)
        p = difference.rank_sum(came)
        each_target = np.broadcast_to(runs[..., None], expected.shape)
        return cls(
            measure=measure,
            arrays=arrays,
            running_times=running_times,
            totals=totals,
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
