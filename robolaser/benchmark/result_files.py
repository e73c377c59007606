"""The files of a benchmark: comparison.json for programs, runs.csv for statistics of one's own, and exports."""

import json
import math
from collections.abc import Sequence
from dataclasses import asdict
from importlib.metadata import version
from typing import Any, Literal

from robolaser.benchmark.iohprofiler import iohprofiler_files
from robolaser.benchmark.result import BenchmarkResult
from robolaser.benchmark.standings import Standings

FORMAT = "robolaser-comparison/1"


def comparison_json(result: BenchmarkResult, standings: Sequence[Standings]) -> str:
    """The text of comparison.json, given the standings of each family of problems."""
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
            for run in sorted(result.failures, key=lambda run: run.key)
        ],
        "standings": [asdict(one) for one in standings],
        "engine": {"name": effort.engine, "workers": effort.workers, "busy": effort.busy},
        "seconds": effort.seconds,
    }
    return json.dumps(content, indent=1, allow_nan=False, ensure_ascii=False) + "\n"


def runs_csv(result: BenchmarkResult) -> str:
    """The text of runs.csv: a row for each run and target; what was not reached is empty."""
    text: str = result.to_frame("targets").to_csv(index=False, lineterminator="\n")
    return text


def exported(result: BenchmarkResult, *, iohprofiler: bool = False, parquet: bool = False) -> dict[str, str | bytes]:
    """What the files for other programs hold, by their names: IOHprofiler's, and tables of runs and improvements."""
    files: dict[str, str | bytes] = {}
    if iohprofiler:
        files |= {f"iohprofiler/{name}": text for name, text in iohprofiler_files(result).items()}
    names: tuple[Literal["runs", "trajectory"], ...] = ("runs", "trajectory") if parquet else ()
    for name in names:
        files[f"{name}.parquet"] = result.to_frame(name).to_parquet(index=False)
    return files


def _finite(value: float) -> Any:
    return value if math.isfinite(value) else None
