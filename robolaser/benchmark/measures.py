"""Measures of a run: its cost above the lowest known, or the distance of its front from the best.

For several objectives it is IGD+ of all candidates so far: the mean distance by which they fall short of the points of
the best front, each objective in units of that front's extent. It has no plateau, a front that is dominated
is never better, and no reference point is drawn. Ishibuchi, Masuda, Tanigaki & Nojima 2015. The best front is the
theoretical one or, where that is not known, the non-dominated feasible candidates of all runs together.
"""

from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from robolaser.arrays import Array
from robolaser.benchmark.evaluator import ConvergenceTrace, not_dominated
from robolaser.benchmark.problem import ProblemSummary
from robolaser.benchmark.run import BenchmarkRun

LOWER = 1e-9  # a solver has improved the best known cost only if it is lower by more than this share
TOLERANCE = 1e-2  # the usual target: J within one per cent of the lowest known (RMS: half of one), a cost so much above
RELATIVE = 10.0 ** np.arange(4.0, -6.5, -0.5)
"""Targets where the cost has a natural zero: from a hundred times the best RMS to half a millionth more than it."""
ABSOLUTE = 10.0 ** (np.arange(10, -41, -1) / 5)  # BBOB's 51, above the lowest: 1e2 to 1e-8. Hansen et al. 2021 (COCO)
FRONTS = 10.0 ** (np.arange(0, -26, -1) / 5)  # of IGD+, from the extent of the best front to a hundred-thousandth of it
TOGETHER = "all runs together"  # source of a front without a theoretical one
CHUNK = 256


def tolerances(family: str, target: float | None) -> Array:
    """Targets of a family of problems, falling, with the one for the ranking."""
    usual = {"calibration": RELATIVE, "several objectives": FRONTS}.get(family, ABSOLUTE)
    wanted = TOLERANCE if target is None else target
    if np.isclose(usual, wanted, rtol=1e-6, atol=0.0).any():
        return usual
    return np.sort(np.append(usual, wanted))[::-1]


def measured(problem: ProblemSummary, runs: Sequence[BenchmarkRun]) -> tuple[ProblemSummary, list[BenchmarkRun]]:
    """A problem with its best known cost or front, and its runs with the costs for the ranking."""
    if problem.objectives > 1:
        return _by_fronts(problem, runs)
    best, found_by = (np.inf, "") if problem.lowest is None else (problem.lowest, problem.found_by)
    for run in runs:
        if run.trace.final < best - (LOWER * abs(best) if np.isfinite(best) else 0.0):
            best, found_by = run.trace.final, run.algorithm
    return replace(problem, best=best, found_by=found_by), list(runs)


def _by_fronts(problem: ProblemSummary, runs: Sequence[BenchmarkRun]) -> tuple[ProblemSummary, list[BenchmarkRun]]:
    found = [run.trace.costs for run in runs if len(run.trace.costs)]
    if problem.front is not None:
        best, by = np.asarray(problem.front, np.float64), "theory"
    elif found:
        every = np.concatenate(found)
        best, by = every[not_dominated(every)], TOGETHER
    else:
        return problem, list(runs)
    extent = np.where((width := np.ptp(best, axis=0)) > 0, width, 1.0)
    ranked = [replace(run, trace=_igd_plus(run.trace, best / extent, extent)) for run in runs]
    return replace(problem, best=0.0, found_by=by), ranked


def _igd_plus(trace: ConvergenceTrace, best: Array, extent: Array) -> ConvergenceTrace:
    nearest, courses = np.full(len(best), np.inf), [np.empty(0)]
    for first in range(0, len(trace.costs), CHUNK):
        found = trace.costs[first : first + CHUNK] / extent
        short = np.linalg.norm(np.maximum(found[:, None] - best, 0.0), axis=2)
        reached = np.minimum(np.minimum.accumulate(short, axis=0), nearest)
        nearest = reached[-1]
        courses.append(reached.mean(axis=1))
    course = np.concatenate(courses)
    kept = np.diff(course, prepend=np.inf) < 0
    return ConvergenceTrace(trace.evaluations[kept], trace.seconds[kept], course[kept])


def attainment(runs: Sequence[BenchmarkRun]) -> Array:
    """The median attainment surface of the runs, (k, m); (0, 0) if half of them found nothing.

    Empirical attainment function: Grunert da Fonseca, Fonseca & Hall 2001.
    """
    import moocore  # noqa: PLC0415 - only several objectives need it

    fronts = [costs[not_dominated(costs)] for run in runs if len(costs := run.trace.costs)]
    if not fronts or 2 * len(fronts) < len(runs):
        return np.empty((0, 0))
    of_run = np.repeat(np.arange(len(fronts)), [len(front) for front in fronts])
    half = 50.0 * len(runs) / len(fronts)  # those that found nothing are runs, too
    return np.asarray(moocore.eaf(np.concatenate(fronts), of_run, percentiles=[half]))[:, :-1]
