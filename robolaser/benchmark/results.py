"""A comparison as others read it: comparison.json for programs, runs.csv for anybody's statistics."""

import csv
import io
import json
import math
from collections.abc import Iterator, Sequence
from dataclasses import asdict
from importlib.metadata import version
from typing import Any

from robolaser.benchmark.result import Comparison
from robolaser.benchmark.results_array import TOLERANCES, targets
from robolaser.benchmark.single_run import Run
from robolaser.benchmark.standings import Standings

FORMAT = "robolaser-comparison/1"
COLUMNS = (
    "problem", "algorithm", "seed", "state", "reason", "tolerance", "target", "reached", "evaluations", "seconds",
    "run_evaluations", "run_seconds", "run_processor_s", "run_best",
)  # fmt: skip
"""Of runs.csv. Empty: the target was not reached."""


def comparison_json(comparison: Comparison, standings: Sequence[Standings]) -> str:
    """What comparison.json holds.

    Args:
        comparison: What was run.
        standings: Of each family of problems.
    """
    effort = comparison.effort
    said = {
        "format": FORMAT,
        "robolaser": version("robolaser"),
        "problems": [asdict(problem) | {"best": _finite(problem.best)} for problem in comparison.problems],
        "algorithms": [{"name": name, "title": title} for name, title in comparison.contestants.items()],
        "refused": [
            {"problem": problem, "algorithm": algorithm, "reason": reason}
            for (problem, algorithm), reason in comparison.refused.items()
        ],
        "seeds": list(comparison.seeds),
        "budget": comparison.budget,
        "time_limit_s": comparison.time_limit_s,
        "runs": {"wanted": comparison.wanted, "made": len(comparison.runs), "failed": len(comparison.failures)},
        "failures": [
            {"problem": run.problem, "algorithm": run.algorithm, "seed": run.seed, "reason": run.reason}
            for run in _in_order(comparison.failures)
        ],
        "standings": [asdict(one) for one in standings],
        "engine": {"name": effort.engine, "workers": effort.workers, "busy": effort.busy},
        "seconds": effort.seconds,
    }
    return json.dumps(said, indent=1, allow_nan=False, ensure_ascii=False) + "\n"


def runs_csv(comparison: Comparison) -> str:
    """What runs.csv holds: a row for each run and target."""
    text = io.StringIO(newline="")
    rows = csv.writer(text, lineterminator="\n")
    rows.writerow(COLUMNS)
    rows.writerows(_rows(comparison))
    return text.getvalue()


def _rows(comparison: Comparison) -> Iterator[tuple[object, ...]]:
    costs = {problem.name: targets(problem.best, problem.scale) for problem in comparison.problems}
    for run in _in_order(comparison.runs):
        evaluations, seconds = run.course.first(costs[run.problem])
        best = "" if math.isinf(run.course.final) else repr(run.course.final)
        whole = (run.evaluations, f"{run.seconds:.6f}", f"{run.processor_s:.6f}", best)
        for tolerance, target, at, by in zip(TOLERANCES, costs[run.problem], evaluations, seconds, strict=True):
            reached = ("yes", int(at), f"{by:.6f}") if math.isfinite(at) else ("no", "", "")
            named = (run.problem, run.algorithm, run.seed, run.state, run.reason)
            yield (*named, f"{tolerance:.6g}", repr(float(target)), *reached, *whole)


def _in_order(runs: Sequence[Run]) -> list[Run]:
    """Sorted by what was asked, not by who happened to be ready first."""
    return sorted(runs, key=lambda run: (run.problem, run.algorithm, run.seed))


def _finite(value: float) -> Any:
    return value if math.isfinite(value) else None
