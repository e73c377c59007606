"""How a comparison was measured, and how to read its figures."""

import importlib.metadata
import platform
from collections.abc import Sequence

from robolaser.benchmark.problem import CALIBRATION, OWN, TEST_FUNCTION
from robolaser.benchmark.result import BenchmarkResult
from robolaser.report.comparison.rows import spans
from robolaser.report.digits import duration, rate
from robolaser.report.page import version

FAMILIES = {CALIBRATION: "Calibration problems", TEST_FUNCTION: "Test functions", OWN: "Own problems"}
"""Headings."""
PACKAGES = ("numpy", "scipy", "pymoo", "cma")
"""Whose versions results depend on."""
FOUND_BY = {"theory": "theory", "": "not found yet"}

READING = (
    ("Target", "A cost slightly above the lowest known. The lowest is not known for certain: it is what robolaser's"
     " own search beforehand or any run has found."),
    ("Success", "Share of the runs that reached the target within the budget; a failed run did not, unless it got there"
     " before it failed. Its interval covers the true share 95 times in a hundred (Wilson)."),
    ("ERT", "Expected running time: what all runs spent until they reached the target or ended, over the number of runs"
     " that reached it. It is what a target costs on average if runs are restarted until one reaches it."),
    ("A12", "How often a run of the one does better than a run of the other, ties counting half: 0.5 is no difference,"
     " 1 is always (Vargha and Delaney)."),
    ("Significant", "If the two were the same, differences like these would occur less than once in twenty comparisons"
     " like this, all of its pairs taken together (Mann and Whitney's test on one problem, van Elteren's over several,"
     " with Holm's correction)."),
    ("Rank", "By the mean rank over blocks of a problem and a seed. In a block, runs that reached the target come"
     " before those that did not: the former by their running time, the latter by how close they came."),
    ("Letters", "Two algorithms that share a letter do not differ significantly; two that share none do (Piepho 2004)."
     " The tests are those of the pairs."),
)  # fmt: skip
"""Each measure in a sentence or two."""


def setting(comparison: BenchmarkResult) -> str:
    """How many algorithms, problems and runs."""
    counts = (
        _many(len(comparison.solvers), "algorithm"),
        _many(len(comparison.problems), "problem"),
        _many(len(comparison.seeds), "seed"),
    )
    return f"{', '.join(counts)}, {comparison.budget:,} evaluations a run"


def missing(comparison: BenchmarkResult) -> str:
    """How far an unfinished comparison is; empty if it is done."""
    made, wanted = len(comparison.runs), comparison.wanted
    if made >= wanted:
        return ""
    return f"{made:,} of {wanted:,} runs so far"


def measured(comparison: BenchmarkResult) -> Sequence[tuple[str, str]]:
    """Conditions of the runs, and the effort."""
    effort = comparison.effort
    versions = ", ".join(f"{name} {of}" for name in PACKAGES if (of := _version(name)))
    return (
        ("Budget", f"{comparison.budget:,} evaluations a run; one is one candidate's cost, or its residuals once"),
        ("Time limit", f"{duration(comparison.time_limit_s)} a run; a run over it has failed"),
        ("Seeds", f"{spans(comparison.seeds)}, the same for all"),
        ("Runs", f"{len(comparison.runs):,} of {comparison.wanted:,}, {len(comparison.failures):,} of them failed"),
        ("Run on", f"{effort.engine or 'nothing yet'}, {_many(effort.workers, 'run')} at a time"),
        ("Took", f"{duration(effort.seconds)}; {rate(effort.busy)} of the workers' time went into runs"),
        ("Versions", f"robolaser {version()}, {versions}, Python {platform.python_version()}"),
    )


def found_by(name: str) -> str:
    """What found the lowest cost."""
    return FOUND_BY.get(name, name)


def _many(count: int, noun: str) -> str:
    return f"{count:,} {noun}" if count == 1 else f"{count:,} {noun}s"


def _version(package: str) -> str:
    try:
        return importlib.metadata.version(package)
    except importlib.metadata.PackageNotFoundError:
        return ""
