"""The files of a benchmark: comparison.json for programs, runs.csv for statistics of one's own, and exports.

The format of IOHprofiler is for the field's own tools, IOHanalyzer and iohinspector: a folder for each solver; in it,
for each problem, a file of JSON that says what was run and a table of every improvement. Doerr, Wang, Ye, van Rijn,
Bäck: IOHprofiler, arXiv:1810.05281.
"""

import json
import math
import re
from collections.abc import Iterator, Sequence
from dataclasses import asdict
from importlib.metadata import version
from pathlib import Path
from typing import Any, Literal

from robolaser.benchmark.problem import ProblemSummary
from robolaser.benchmark.result import BenchmarkResult
from robolaser.benchmark.single_run import BenchmarkRun
from robolaser.benchmark.standings import Standings

FORMAT = "robolaser-comparison/1"
LAYOUT = "0.3.18"
"""Version of the IOHexperimenter whose files these are like."""
HEADER = "evaluations raw_y seconds"


def comparison_json(result: BenchmarkResult, standings: Sequence[Standings]) -> str:
    """The text of comparison.json, given the standings of each family of problems."""
    effort = result.effort
    content = {
        "format": FORMAT,
        "robolaser": version("robolaser"),
        "problems": [
            asdict(problem) | {"best": problem.best if math.isfinite(problem.best) else None}
            for problem in result.problems
        ],
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


def iohprofiler_files(result: BenchmarkResult) -> dict[str, str]:
    """What the files of all runs hold that found anything, by their names in the export's folder."""
    files: dict[str, str] = {}
    for number, problem in enumerate(result.problems, start=1):
        for algorithm, title in result.solvers.items():
            runs = [
                run
                for run in sorted(result.runs, key=lambda run: run.seed)
                if (run.problem, run.algorithm) == (problem.name, algorithm) and len(run.trace.costs)
            ]
            if not runs:
                continue
            name = f"{number}_{_plain(problem.name)}"
            home = Path(_plain(algorithm))
            table = Path(f"data_f{name}") / f"IOHprofiler_f{number}_DIM{problem.dimension}.dat"
            header = _about(problem, number, algorithm, title, table, runs)
            files[str(home / f"IOHprofiler_f{name}.json")] = json.dumps(header, indent=1) + "\n"
            files[str(home / table)] = "\n".join(line for run in runs for line in _lines(run)) + "\n"
    return files


def _about(
    problem: ProblemSummary, number: int, algorithm: str, title: str, table: Path, runs: Sequence[BenchmarkRun]
) -> dict[str, Any]:
    return {
        "version": LAYOUT,
        "suite": f"robolaser {version('robolaser')}: {problem.family}",
        "function_id": number,
        "function_name": problem.name,
        "maximization": False,
        "algorithm": {"name": algorithm, "info": title},
        "attributes": HEADER.split(),
        "scenarios": [
            {
                "dimension": problem.dimension,
                "path": table.as_posix(),
                "runs": [
                    {
                        "instance": run.seed,
                        "evals": run.evaluations,
                        "best": {"evals": int(run.trace.evaluations[-1]), "y": run.trace.final, "x": []},
                    }
                    for run in runs
                ],
            }
        ],
    }


def _lines(run: BenchmarkRun) -> Iterator[str]:
    """A run as lines of the table; the tools tell runs by their first evaluation and want the last one too."""
    trace = run.trace
    yield HEADER
    if trace.evaluations[0] > 1:
        yield "1 inf 0.0"
    for evaluations, seconds, cost in zip(trace.evaluations, trace.seconds, trace.costs, strict=True):
        yield f"{evaluations} {float(cost)!r} {seconds:.6f}"
    if trace.evaluations[-1] < run.evaluations:
        yield f"{run.evaluations} {trace.final!r} {run.seconds:.6f}"


def _plain(name: str) -> str:
    """A name as part of a path."""
    return re.sub(r"[^\w.=+-]+", "_", name)
