"""What came of a comparison: its problems, its solvers, and every run."""

from collections.abc import Mapping
from dataclasses import dataclass, field
from functools import cached_property
from typing import TYPE_CHECKING, Literal, final

import numpy as np

from robolaser.benchmark.measures import tolerances
from robolaser.benchmark.problem_summary import ProblemSummary
from robolaser.benchmark.result_arrays import ResultArrays
from robolaser.benchmark.run import FAILED, BenchmarkRun

if TYPE_CHECKING:
    import pandas as pd


@final
@dataclass(frozen=True)
class Effort:
    """What a comparison took."""

    engine: str  # where runs were made
    workers: int  # runs at a time
    seconds: float  # wall time, over all sessions
    run_s: float  # of all runs

    @property
    def busy(self) -> float:
        """Share of the workers' time that went into runs."""
        capacity = self.seconds * self.workers
        return min(self.run_s / capacity, 1.0) if capacity > 0 else 0.0


@final
@dataclass(frozen=True, eq=False, repr=False)
class BenchmarkResult:
    """All that was planned, and every run so far.

    Attributes:
        problems: The problems.
        solvers: Title of each by name, in the order in which they were named.
        know_budget: Those that search differently with another budget.
        refused: Why a solver does not apply to a problem, by (problem, solver).
        seeds: Of the runs: each solver has a run with each of them on each problem.
        budget: Evaluations of a run, as stated: 20000, or 1000d for a thousand times the number of variables.
        target: The tolerance by which solvers are ranked, where it was stated.
        time_limit_s: Wall time of a run [s].
        runs: The runs that were made; of several objectives their costs are IGD+.
        made: The same as they were made, with objectives for costs.
        effort: Time and workers.
        journal: The runs as runs.jsonl has them.
    """

    problems: tuple[ProblemSummary, ...]
    solvers: Mapping[str, str]
    know_budget: frozenset[str]
    refused: Mapping[tuple[str, str], str]
    seeds: tuple[int, ...]
    budget: str
    target: float | None
    time_limit_s: float
    runs: tuple[BenchmarkRun, ...]
    made: tuple[BenchmarkRun, ...]
    effort: Effort
    journal: str = field(default="", repr=False)

    @property
    def families(self) -> tuple[str, ...]:
        """Families of the problems, in order."""
        return tuple(dict.fromkeys(problem.family for problem in self.problems))

    @property
    def wanted(self) -> int:
        """Number of runs that were planned."""
        return (len(self.problems) * len(self.solvers) - len(self.refused)) * len(self.seeds)

    @cached_property
    def failures(self) -> tuple[BenchmarkRun, ...]:
        """The runs that failed."""
        return tuple(run for run in self.runs if run.state == FAILED)

    def of(self, family: str) -> tuple[ProblemSummary, ...]:
        """The problems of a family."""
        return tuple(problem for problem in self.problems if problem.family == family)

    def arrays(self, family: str) -> ResultArrays:
        """Runs on the problems of a family as arrays, without solvers that apply to none of them."""
        problems = self.of(family)
        taking_part = [name for name in self.solvers if any((one.name, name) not in self.refused for one in problems)]
        return ResultArrays.of(self.runs, problems, taking_part, self.seeds, target=self.target)

    def to_frame(self, of: Literal["runs", "trajectory", "targets"] = "runs") -> "pd.DataFrame":
        """The runs as a table.

        Args:
            of: Which table: of runs, of their improvements, or of runs and targets as in runs.csv.

        Returns:
            Rows in the order of problem, algorithm and seed. Of "runs" a row for each run: `problem`, `family`,
            `dimension`, `algorithm`, `seed`, `state` ("done" or "failed"), `reason`, `evaluations`, `seconds`,
            `processor_s`, `best` (lowest cost, of several objectives IGD+; infinite if nothing feasible was found),
            `violation`, and of the problem `lowest` (the lowest cost known). Of "trajectory" a row for each
            improvement: `problem`, `algorithm`, `seed`, `evaluations`, `seconds`, `cost`. Of "targets" a row for each
            run and target: `problem`, `algorithm`, `seed`, `state`, `reason`, `tolerance`, `target` (its cost),
            `reached` ("yes" or "no"), `evaluations` and `seconds` to it (missing if it was not reached), and
            `run_evaluations`, `run_seconds`, `run_processor_s`, `run_best`, `run_violation` of the whole run.
        """
        import pandas as pd  # noqa: PLC0415 - a third of a second

        problems = {problem.name: problem for problem in self.problems}
        runs = sorted(self.runs, key=lambda run: run.key)
        if of == "runs":
            rows = [
                {"problem": run.problem, "family": problems[run.problem].family,
                 "dimension": problems[run.problem].dimension, "algorithm": run.algorithm, "seed": run.seed,
                 "state": run.state, "reason": run.reason, "evaluations": run.evaluations, "seconds": run.seconds,
                 "processor_s": run.processor_s, "best": run.trace.final, "violation": run.violation,
                 "lowest": problems[run.problem].best}
                for run in runs
            ]  # fmt: skip
            return pd.DataFrame(rows)
        if of == "trajectory":
            columns = ["problem", "algorithm", "seed", "evaluations", "seconds", "cost"]
            steps = [
                (*run.key, *step)
                for run in runs
                for step in zip(run.trace.evaluations, run.trace.seconds, run.trace.costs, strict=True)
            ]
            return pd.DataFrame(steps, columns=columns)
        return pd.DataFrame([row for run in runs for row in _targets(run, problems[run.problem], self.target)])


def _targets(run: BenchmarkRun, problem: ProblemSummary, target: float | None) -> list[dict[str, object]]:
    at = tolerances(problem.family, target)
    costs = problem.best + at * problem.scale
    evaluations, seconds = run.trace.first_hits(costs)
    return [
        {"problem": run.problem, "algorithm": run.algorithm, "seed": run.seed, "state": run.state,
         "reason": run.reason, "tolerance": at[i], "target": costs[i],
         "reached": "yes" if np.isfinite(evaluations[i]) else "no",
         "evaluations": int(evaluations[i]) if np.isfinite(evaluations[i]) else None,
         "seconds": seconds[i] if np.isfinite(seconds[i]) else None,
         "run_evaluations": run.evaluations, "run_seconds": run.seconds, "run_processor_s": run.processor_s,
         "run_best": run.trace.final, "run_violation": run.violation}
        for i in range(len(at))
    ]  # fmt: skip
