"""What came of runs, as ordinal numbers: outcomes and their mean ranks.

A block is a (problem, seed) in which each algorithm has one run. Mean ranks give the order and no test: whether two
algorithms differ is for the tests of pairs to say (`difference`), whoever else takes part.
"""

import numpy as np
from scipy.stats import rankdata

from robolaser.arrays import Array


def outcomes(running_times: Array, final: Array) -> Array:
    """Places of all runs on each problem, from 1, equal ones sharing theirs: times and final excesses (p, a, s).

    Runs that reached the target come first, the cheaper the better; then the others by what they ended with; last those
    that found nothing; NaN where there is no run. Hansen et al. 2021 (COCO) rank like this where targets are not always
    reached.
    """
    places = np.full(running_times.shape, np.nan)
    for of_problem, time, excess in zip(places, running_times, final, strict=True):
        there, reached = ~np.isnan(time), np.isfinite(time)
        excess_of_rest = np.where(reached, -np.inf, np.where(np.isnan(excess), np.inf, excess))
        keys = np.stack([excess_of_rest[there], np.where(reached, time, 0.0)[there]], axis=1)
        if len(keys):
            of_problem[there] = np.unique(keys, axis=0, return_inverse=True)[1].reshape(-1) + 1.0
    return places


def complete(outcomes: Array) -> Array:
    """Outcomes (p, a, s) in blocks in which every algorithm has a run, (n, a)."""
    problems, algorithms, seeds = outcomes.shape
    blocks = np.moveaxis(outcomes, 1, 2).reshape(problems * seeds, algorithms)
    whole: Array = blocks[~np.isnan(blocks).any(axis=1)]
    return whole


def mean_ranks(blocks: Array) -> Array:
    """Mean rank of each algorithm, 1 being best, (n, a) -> (a,); NaN without blocks."""
    if not blocks.size:
        return np.full(blocks.shape[1], np.nan)
    means: Array = rankdata(blocks, axis=1).mean(axis=0)
    return means
