"""The files of a benchmark: comparison.json for programs, runs.csv for statistics of one's own."""

import csv
import io
import json
import math
from collections.abc import Iterator, Sequence
from dataclasses import asdict
from importlib.metadata import version
from typing import Any

from robolaser.benchmark.result import BenchmarkResult
from robolaser.benchmark.result_arrays import TOLERANCES, targets
from robolaser.benchmark.single_run import BenchmarkRun
from robolaser.benchmark.standings import Standings

FORMAT = "robolaser-comparison/1"
COLUMNS = (
    "problem", "algorithm", "seed", "state", "reason", "tolerance", "target", "reached", "evaluations", "seconds",
    "run_evaluations", "run_seconds", "run_processor_s", "run_best",
    "run_violation",
)  # fmt: skip
"""Columns of runs.csv. Empty cells: the target was not reached."""


def comparison_json(result: BenchmarkResult, standings: Sequence[Standings]) -> str:
    """The text of comparison.json.

    Args:
        result: The result.
        standings: Those of each family of problems.
    """
    effort = result.effort
    content = {
        "format": FORMAT,
        "robolaser": version("robolaser"),
        "problems": [asdict(problem) | {"best": _finite(problem.best)} for problem in result.problems],
        "algorithms": [{"name": name, "title": title} for name, title in result.solvers.items()],
        "refused": [
            {"problem": problem, "algorithm": algorithm, "reason": reason}
            for (problem, algorithm), reason in result.refused.items()
        ],
        "seeds": list(result.seeds),
        "budget": result.budget,
        "time_limit_s": result.time_limit_s,
        "runs": {"wanted": result.wanted, "made": len(result.runs), "failed": len(result.failures)},
        "failures": [
            {"problem": run.problem, "algorithm": run.algorithm, "seed": run.seed, "reason": run.reason}
            for run in _in_order(result.failures)
        ],
        "standings": [asdict(one) for one in standings],
        "engine": {"name": effort.engine, "workers": effort.workers, "busy": effort.busy},
        "seconds": effort.seconds,
    }
    return json.dumps(content, indent=1, allow_nan=False, ensure_ascii=False) + "\n"


def runs_csv(result: BenchmarkResult) -> str:
    """The text of runs.csv: a row for each run and target."""
    text = io.StringIO(newline="")
    rows = csv.writer(text, lineterminator="\n")
    rows.writerow(COLUMNS)
    rows.writerows(_rows(result))
    return text.getvalue()


def _rows(result: BenchmarkResult) -> Iterator[tuple[object, ...]]:
    costs = {problem.name: targets(problem.best, problem.scale) for problem in result.problems}
    for run in _in_order(result.runs):
        evaluations, seconds = run.trace.first_hits(costs[run.problem])
        best = "" if math.isinf(run.trace.final) else repr(run.trace.final)
        whole = (run.evaluations, f"{run.seconds:.6f}", f"{run.processor_s:.6f}", best, repr(run.violation))
        for tolerance, target, at, by in zip(TOLERANCES, costs[run.problem], evaluations, seconds, strict=True):
            reached = ("yes", int(at), f"{by:.6f}") if math.isfinite(at) else ("no", "", "")
            named = (run.problem, run.algorithm, run.seed, run.state, run.reason)
            yield (*named, f"{tolerance:.6g}", repr(float(target)), *reached, *whole)


def _in_order(runs: Sequence[BenchmarkRun]) -> list[BenchmarkRun]:
    """Sorted by what was planned, not by which run happened to be done first."""
    return sorted(runs, key=lambda run: (run.problem, run.algorithm, run.seed))


def _finite(value: float) -> Any:
    return value if math.isfinite(value) else None
