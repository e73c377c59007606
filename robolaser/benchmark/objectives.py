"""How good the fronts are that runs ended with, by other measures than the hypervolume.

IGD+: Ishibuchi, Masuda, Tanigaki & Nojima 2015. Empirical attainment function: Grunert da Fonseca, Fonseca & Hall 2001.
"""

from collections.abc import Sequence
from typing import TYPE_CHECKING

import moocore
import numpy as np

from robolaser.arrays import Array
from robolaser.benchmark.result import BenchmarkResult

if TYPE_CHECKING:
    import pandas as pd


def igd_plus(result: BenchmarkResult) -> "pd.DataFrame":
    """IGD+ of each run: the mean distance by which its front falls short of the points of the best known one.

    That is what all runs on the problem found together; distances are in units of its extent.

    Returns:
        Columns `problem`, `algorithm`, `seed`, `igd_plus`; infinite for a run that found nothing.
    """
    import pandas as pd  # noqa: PLC0415 - a third of a second

    rows = []
    for problem in result.problems:
        runs = [run for run in result.runs if run.problem == problem.name and run.front is not None]
        found = [run.front for run in runs if run.front is not None and len(run.front)]
        if not found:
            continue
        together = np.concatenate(found)
        best = together[moocore.is_nondominated(together)]
        extent = np.where((width := np.ptp(best, axis=0)) > 0, width, 1.0)
        for run in runs:
            there = run.front is not None and len(run.front)
            short = float(moocore.igd_plus(run.front / extent, ref=best / extent)) if there else np.inf
            rows.append((*run.key, short))
    return pd.DataFrame(rows, columns=["problem", "algorithm", "seed", "igd_plus"])


def attainment(
    result: BenchmarkResult, problem: str, algorithm: str, shares: Sequence[float] = (0.25, 0.5, 0.75)
) -> Array:
    """Empirical attainment surfaces of a solver on a problem: what so large a share of its runs attained.

    Returns:
        Corners of the surfaces, (k, m + 1): objective values, and the share last; without fronts (0, 0).
    """
    fronts = [run.front for run in result.runs if run.key[:2] == (problem, algorithm) and run.front is not None]
    if not any(len(front) for front in fronts):
        return np.empty((0, 0))
    of_run = np.repeat(np.arange(len(fronts)), [len(front) for front in fronts])
    corners: Array = moocore.eaf(np.concatenate(fronts), of_run, percentiles=[100 * share for share in shares])
    corners[:, -1] /= 100
    return corners
