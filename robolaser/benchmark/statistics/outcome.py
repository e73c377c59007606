"""What came of a run, as one ordinal number."""

import numpy as np

from robolaser.arrays import Array


def outcomes(running_times: Array, final: Array) -> Array:
    """Places of all runs on each problem, from 1, equal ones sharing theirs: times and final excesses (p, a, s).

    Runs that reached the target come first, the cheaper the better; then the others by what they ended with; last those
    that found nothing; NaN where there is no run. Hansen et al. 2021 (COCO) rank like this where targets are not always
    reached.
    """
    ranks = np.full(running_times.shape, np.nan)
    for of_problem, time, excess in zip(ranks, running_times, final, strict=True):
        there = ~np.isnan(time)
        reached = np.isfinite(time)
        excess_of_rest = np.where(reached, -np.inf, np.where(np.isnan(excess), np.inf, excess))
        keys = np.stack([excess_of_rest[there], np.where(reached, time, 0.0)[there]], axis=1)
        if len(keys):
            of_problem[there] = np.unique(keys, axis=0, return_inverse=True)[1].reshape(-1) + 1.0
    return ranks
