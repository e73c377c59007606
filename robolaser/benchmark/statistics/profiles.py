"""What runs reached by when: shares of targets within a budget, and costs after so many evaluations.

Hansen, Auger, Brockhoff & Tusar 2022, "Anytime performance assessment in blackbox optimization benchmarking".
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
    found = np.full((running_times.shape[1], len(budgets)), np.nan)
    for a, row in enumerate(found):
        there = np.sort(running_times[:, a][~np.isnan(running_times[:, a])])
        if len(there):
            row[:] = np.searchsorted(there, budgets, side="right") / len(there)
    return found
