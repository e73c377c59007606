"""The expected running time to a target, ERT, its ratios between algorithms, and targets reached by when.

What an algorithm pays on average until it reaches a target if it is begun anew, with another seed, as often as it
fails: all that all runs paid up to the target or their end, over the number of those that reached it. Auger & Hansen
2005; Hansen, Auger, Ros, Mersmann, Tusar & Brockhoff 2021 (COCO), section 5.
"""

import numpy as np

from robolaser.arrays import Array

BUDGETS = 200  # of a curve


def expected(running_times: Array, totals: Array) -> Array:
    """ERT to a target, running times and totals of the whole runs (..., s) -> (...,).

    Infinite where no run reached the target, NaN where there are no runs.
    """
    reached = np.isfinite(running_times)
    paid = np.nansum(np.where(reached, running_times, totals), axis=-1)
    with np.errstate(divide="ignore", invalid="ignore"):
        return np.asarray(paid / reached.sum(axis=-1))


def mean_ratios(expected: Array) -> Array:
    """How many times longer the other takes than the one: geometric mean over problems on which both succeeded.

    ERT (p, a) -> (a, a), the second algorithm's over the first's; NaN where there is no such problem.
    """
    solved = np.where(np.isfinite(expected), expected, np.nan)
    logs = np.ma.masked_invalid(np.log(solved[:, None, :] / solved[:, :, None]))
    return np.asarray(np.exp(logs.mean(axis=0)).filled(np.nan))


def budgets(running_times: Array, totals: Array) -> Array:
    """Some budgets (b,) from the first target that any run reached to the end of the longest, evenly in logarithms.

    Empty if no run reached any.
    """
    reached = running_times[np.isfinite(running_times) & (running_times > 0)]
    if not len(reached):
        return np.empty(0)
    return np.geomspace(reached.min(), max(np.nanmax(totals), reached.max()), BUDGETS)


def shares(running_times: Array, budgets: Array) -> Array:
    """Shares of (problem, seed, target) reached within budgets, (p, a, s, t) and (g,) -> (a, g); NaN without runs.

    Hansen, Auger, Brockhoff & Tusar 2022, "Anytime performance assessment in blackbox optimization benchmarking".
    """
    found = np.full((running_times.shape[1], len(budgets)), np.nan)
    for a, row in enumerate(found):
        there = np.sort(running_times[:, a][~np.isnan(running_times[:, a])])
        if len(there):
            row[:] = np.searchsorted(there, budgets, side="right") / len(there)
    return found
