"""Tables of failures: runs that failed, and algorithms that cannot solve a problem."""

from collections.abc import Iterator, Sequence
from itertools import groupby

from robolaser.benchmark.result import BenchmarkResult
from robolaser.report.document import Cell, Column, Table


def failure_table(comparison: BenchmarkResult) -> Table:
    """Runs that failed, those with one reason together."""
    columns = [
        Column("Algorithm", "name"),
        Column("Runs", "number"),
        Column("Reason", "wide"),
        Column("Runs on", "wide"),
    ]
    rows = [
        (name, Cell(str(count), order=count), reason, where) for name, reason, count, where in failure_rows(comparison)
    ]
    return Table(columns, rows)


def refusal_table(comparison: BenchmarkResult) -> Table:
    """Algorithms that cannot solve a problem, and why."""
    columns = [Column("Algorithm", "name"), Column("Problem", "wide"), Column("Reason", "wide")]
    return Table(columns, list(refusal_rows(comparison)))


def failure_rows(comparison: BenchmarkResult) -> Iterator[tuple[str, str, int, str]]:
    """Algorithm, reason, runs, and on which problems with which seeds."""
    order = list(comparison.solvers)
    failures = sorted(
        comparison.failures, key=lambda run: (order.index(run.algorithm), run.reason, run.problem, run.seed)
    )
    for (name, reason), runs in groupby(failures, key=lambda run: (run.algorithm, run.reason)):
        group = list(runs)
        where = [
            f"{problem}: seed {spans([run.seed for run in some])}"
            for problem, some in groupby(group, key=lambda run: run.problem)
        ]
        yield name, reason, len(group), "; ".join(where)


def refusal_rows(comparison: BenchmarkResult) -> Iterator[tuple[str, str, str]]:
    """Algorithm, problems it was not run on, and why."""
    grouped: dict[tuple[str, str], list[str]] = {}
    for (problem, name), reason in comparison.refused.items():
        grouped.setdefault((name, reason), []).append(problem)
    for (name, reason), problems in grouped.items():
        yield name, ", ".join(problems), reason


def spans(numbers: Sequence[int]) -> str:
    """Whole numbers, neighbours as from-to."""
    runs = [[number for _, number in group]
            for _, group in groupby(enumerate(sorted(numbers)), key=lambda pair: pair[1] - pair[0])]  # fmt: skip
    return ", ".join(f"{run[0]} to {run[-1]}" if len(run) > 2 else ", ".join(map(str, run)) for run in runs)
