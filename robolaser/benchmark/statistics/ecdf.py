"""Shares of all targets on all problems that an algorithm's runs reached by so many evaluations or seconds.

Hansen, Auger, Brockhoff & Tusar 2022, "Anytime performance assessment in blackbox optimization benchmarking". Budgets
are plain evaluations or seconds, not per dimension: these problems are no one function scaled to more variables, and
who calibrates pays for evaluations.
"""

import numpy as np

from robolaser.arrays import Array


def budgets(running_times: Array, totals: Array, points: int = 200) -> Array:
    """Budgets (points,) from the first target that any run reached to the end of the longest, evenly in logarithms.

    Empty if no run reached any.
    """
    reached = running_times[np.isfinite(running_times) & (running_times > 0)]
    if not len(reached):
        return np.empty(0)
    return np.geomspace(reached.min(), max(np.nanmax(totals), reached.max()), points)


def shares(running_times: Array, budgets: Array) -> Array:
    """Shares of (problem, seed, target) reached within budgets, (p, a, s, t) and (g,) -> (a, g); NaN without runs."""
    of_algorithms = [running_times[:, a].ravel() for a in range(running_times.shape[1])]
    found = np.full((len(of_algorithms), len(budgets)), np.nan)
    for row, of_one in zip(found, of_algorithms, strict=True):
        there = np.sort(of_one[~np.isnan(of_one)])
        if len(there):
            row[:] = np.searchsorted(there, budgets, side="right") / len(there)
    return found


def areas(running_times: Array, first: float, last: float) -> Array:
    """Area under the ECDF on a logarithmic axis of budgets, (p, a, s, t) -> (a,), 0 to 1; NaN without runs.

    That is, the mean over (problem, seed, target) of the share of the axis that was left when it was reached. Lopez-
    Ibanez, Vermetten, Dreo & Doerr 2024, "Using the empirical attainment function for analyzing single-objective black-
    box optimization algorithms".
    """
    left = np.log(last / np.clip(running_times, first, last)) / np.log(last / first)
    there = ~np.isnan(running_times)
    total, count = np.where(there, left, 0.0).sum(axis=(0, 2, 3)), there.sum(axis=(0, 2, 3))
    area: Array = total / np.where(count > 0, count, np.nan)
    return area
