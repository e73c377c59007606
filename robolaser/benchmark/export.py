"""The files of a comparison: comparison.json for programs, runs.csv for further statistics, IOHprofiler's.

The format of IOHprofiler is for the field's own tools, IOHanalyzer and iohinspector: a folder for each solver; in it,
for each problem, a JSON file on the runs and a table of every improvement. Doerr, Wang, Ye, van Rijn,
Bäck: IOHprofiler, arXiv:1810.05281.
"""

import json
import math
import re
import sys
from collections.abc import Iterator, Sequence
from dataclasses import asdict
from importlib.metadata import version
from pathlib import Path
from typing import Any

from robolaser.benchmark.problem import ProblemSummary
from robolaser.benchmark.result import BenchmarkResult
from robolaser.benchmark.run import BenchmarkRun
from robolaser.benchmark.standings.table import Standings
from robolaser.data.result_folder import json_text

FORMAT = "robolaser-comparison/1"
LAYOUT = "0.3.18"  # version of the IOHexperimenter with this file format
HEADER = "evaluations raw_y seconds"
PRIVATE = ("fingerprint", "front")


def comparison_json(result: BenchmarkResult, standings: Sequence[Standings]) -> str:
    """The text of comparison.json, given the standings of each family of problems."""
    content = {
        "format": FORMAT,
        "robolaser": version("robolaser"),
        "problems": [_problem(one, standings) for one in result.problems],
        "algorithms": [
            {"name": name, "title": title, "knows_budget": name in result.know_budget}
            for name, title in result.solvers.items()
        ],
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
        "engine": {"name": result.engine, "workers": result.workers},
        "seconds": result.seconds,
    }
    return json_text(content)


def _problem(problem: ProblemSummary, standings: Sequence[Standings]) -> dict[str, Any]:
    tolerance = next(one.tolerance for one in standings if one.family == problem.family)
    found = math.isfinite(problem.best)
    return {
        **{name: value for name, value in asdict(problem).items() if name not in PRIVATE},
        "best": problem.best if found else None,
        "target": problem.target(tolerance) if found else None,
    }


def runs_csv(result: BenchmarkResult) -> str:
    """The text of runs.csv: a row for each run and target; unreached ones have empty cells."""
    return str(result.to_frame("targets").to_csv(index=False, lineterminator="\n"))


def iohprofiler_files(result: BenchmarkResult) -> dict[str, str]:
    """Contents of the files of all runs, also without a result, by their names in the export's folder."""
    files, homes = dict[str, str](), dict[str, str]()
    for algorithm in result.solvers:
        plain = _plain(algorithm)
        homes[algorithm] = f"{plain}~{len(homes) + 1}" if plain in homes.values() else plain  # `a b` and `a/b`
    for number, problem in enumerate(result.problems, start=1):
        for algorithm, title in result.solvers.items():
            runs = [run for run in result.runs if run.key[:2] == (problem.name, algorithm)]
            if not runs:
                continue
            runs.sort(key=lambda run: run.seed)
            name = f"{number}_{_plain(problem.name)}"
            home = Path(homes[algorithm])
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
                        "evals": max(run.evaluations, 1),
                        "best": {"evals": int(run.trace.evaluations[-1]) if len(run.trace.costs) else 1,
                                 "y": min(run.trace.final, sys.float_info.max), "x": []},  # JSON has no infinity
                    }
                    for run in runs
                ],
            }
        ],
    }  # fmt: skip


def _lines(run: BenchmarkRun) -> Iterator[str]:
    """A run as lines of the table; the tools identify runs by their first evaluation and need the last one, too."""
    trace, last = run.trace, 1
    yield HEADER
    if not len(trace.costs) or trace.evaluations[0] > 1:
        yield "1 inf 0.0"
    for evaluations, seconds, cost in zip(trace.evaluations, trace.seconds, trace.costs, strict=True):
        last = int(evaluations)
        yield f"{last} {float(cost)!r} {seconds:.6f}"
    if last < run.evaluations:
        yield f"{run.evaluations} {trace.final!r} {run.seconds:.6f}"


def _plain(name: str) -> str:
    """A name as part of a path."""
    return re.sub(r"[^\w.=+-]+", "_", name)
