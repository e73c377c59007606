"""A comparison in words: its targets, how far costs are above them, and how it was measured."""

import importlib.metadata
import math
import platform
from collections.abc import Sequence

from robolaser.benchmark.problem import ProblemSummary
from robolaser.benchmark.result import BenchmarkResult
from robolaser.report.digits import duration, plain, times
from robolaser.report.page import version

FAMILIES = {
    "calibration": "Calibration problems",
    "test function": "Test functions",
    "own problem": "Own problems",
    "several objectives": "Several objectives",
}  # headings
PACKAGES = ("numpy", "scipy", "pymoo", "cma")  # packages whose versions affect results
SAME = 1e-6  # excess of an RMS that counts as none
FOUND_BY = {"theory": "by theory", "robolaser's own search": "by robolaser's own search", "": ""}


def target(problem: ProblemSummary, tolerance: float) -> str:
    """A target of a problem, with its cost: "a cost of at most 0.01, 0.01 above the lowest known"."""
    if not math.isfinite(problem.best):
        return "not known yet: no run found a feasible candidate"
    if problem.objectives > 1:
        return f"IGD+ of at most {number(tolerance)}"
    reached = problem.target(tolerance)
    if problem.floor is not None:
        share = math.sqrt(1.0 + tolerance) - 1.0
        return f"J of at most {plain(reached, problem.unit)}, an RMS within {_percent(share)} of the lowest known"
    where = FOUND_BY.get(problem.found_by, f"found by {problem.found_by}")
    digits = max(1 + math.ceil(math.log10(max(abs(reached), tolerance) / tolerance)), 2)
    return (
        f"a cost of at most {reached:.{digits}g}, {number(tolerance)} above the lowest known,"
        f" {problem.best:.{digits}g} {where}"
    )


def excess(problem: ProblemSummary, tolerance: float) -> str:
    """Excess over the best known, for a person."""
    if not math.isfinite(tolerance):
        return "" if math.isnan(tolerance) else "nothing found"
    if problem.objectives > 1:
        return number(tolerance)
    if problem.floor is not None and problem.scale > problem.floor:
        share = math.sqrt(1.0 + max(tolerance, 0.0)) - 1.0
        if share < SAME:
            return "best"
        return f"{times(1.0 + share)} times" if share >= 2.0 else f"+{_percent(share)}"
    cost = tolerance * problem.scale
    return "best" if cost == 0 else f"+{plain(cost, problem.unit, 2)}"


def number(value: float) -> str:
    """A tolerance: few digits, and a bare power of ten where it is one."""
    return f"{value:,.0f}" if value >= 10.0 else plain(value, "", 2).removeprefix("1 × ")


def setting(comparison: BenchmarkResult) -> str:
    """Numbers of algorithms, problems and runs, and the progress of an unfinished comparison."""
    counts = (
        _many(len(comparison.solvers), "algorithm"),
        _many(len(comparison.problems), "problem"),
        _many(len(comparison.seeds), "seed"),
    )
    made, wanted = len(comparison.runs), comparison.wanted
    missing = f"; {made:,} of {wanted:,} runs so far" if made < wanted else ""
    return f"{', '.join(counts)}, {budget(comparison)} a run{missing}"


def budget(comparison: BenchmarkResult) -> str:
    """Evaluations of a run."""
    stated = comparison.budget
    return f"{stated[:-1]} evaluations for each variable" if stated.endswith("d") else f"{stated} evaluations"


def measured(comparison: BenchmarkResult) -> Sequence[tuple[str, str]]:
    """Conditions of the runs."""
    seeds = comparison.seeds
    versions = ", ".join(f"{name} {importlib.metadata.version(name)}" for name in PACKAGES)
    ended = sum(bool(run.reason) for run in comparison.runs) - len(comparison.failures)
    return (
        ("Budget", f"{budget(comparison)} a run, each of one candidate's cost or residuals"),
        (
            "Time limit",
            f"{duration(comparison.time_limit_s)} a run; {ended} runs were ended by it and count with their results",
        ),
        ("Seeds", f"{_many(len(seeds), 'seed')} from {min(seeds)} to {max(seeds)}, the same for all"),
        ("Runs", f"{len(comparison.runs):,} of {comparison.wanted:,}, {len(comparison.failures):,} of them failed"),
        ("Run on", f"{comparison.engine or 'nothing yet'}, {_many(comparison.workers, 'run')} at a time"),
        ("Took", duration(comparison.seconds)),
        ("Versions", f"robolaser {version()}, {versions}, Python {platform.python_version()}"),
    )


def _percent(share: float) -> str:
    return f"{100 * share:.0f} %" if share >= 0.1 else f"{plain(100 * share, '', 2)} %"


def _many(count: int, noun: str) -> str:
    return f"{count:,} {noun}" if count == 1 else f"{count:,} {noun}s"
