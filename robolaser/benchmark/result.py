"""A benchmark's result: its problems, its solvers and every run so far."""

from collections.abc import Mapping
from dataclasses import dataclass, field, replace
from typing import TYPE_CHECKING, Literal, final

from robolaser.benchmark.frames import FRAMES
from robolaser.benchmark.problem import ProblemSummary
from robolaser.benchmark.result_arrays import ResultArrays
from robolaser.benchmark.single_run import FAILED, BenchmarkRun

if TYPE_CHECKING:
    import pandas as pd


@final
@dataclass(frozen=True)
class Effort:
    """What the benchmark itself took, over all its sessions if it was resumed."""

    engine: str  # where the last session's runs were made: "this machine" or the address of a Dask scheduler
    workers: int  # runs at a time in the last session
    seconds: float  # wall time
    capacity_s: float  # wall time of all workers together
    busy_s: float  # the part of it that went into runs

    @property
    def busy(self) -> float:
        """Share of the workers' time that went into runs, 0 to 1."""
        return min(self.busy_s / self.capacity_s, 1.0) if self.capacity_s > 0 else 0.0


@final
@dataclass(frozen=True, eq=False, repr=False)
class BenchmarkResult:
    """All that was planned, and every run so far.

    Attributes:
        problems: The problems.
        solvers: Title of each by name, in the order in which they were named.
        refused: Why a solver does not apply to a problem, by (problem, solver).
        seeds: Of the runs: each solver has a run with each of them on each problem.
        budget: Evaluations a run may spend.
        time_limit_s: Wall time a run may take [s].
        runs: The runs that were made.
        effort: Time and workers.
        dropped: After how many seeds a race dropped a solver.
    """

    problems: tuple[ProblemSummary, ...]
    solvers: Mapping[str, str]
    refused: Mapping[tuple[str, str], str]
    seeds: tuple[int, ...]
    budget: int
    time_limit_s: float
    runs: tuple[BenchmarkRun, ...]
    effort: Effort
    dropped: Mapping[str, int] = field(default_factory=dict)

    @property
    def families(self) -> tuple[str, ...]:
        """Families of the problems, in order."""
        return tuple(dict.fromkeys(problem.family for problem in self.problems))

    @property
    def wanted(self) -> int:
        """Number of runs that were planned."""
        problems = dict.fromkeys(self.solvers, len(self.problems))
        for _, name in self.refused:
            problems[name] -= 1
        return sum(count * self.dropped.get(name, len(self.seeds)) for name, count in problems.items())

    @property
    def failures(self) -> tuple[BenchmarkRun, ...]:
        """The runs that failed."""
        return tuple(run for run in self.runs if run.state == FAILED)

    def of(self, family: str) -> tuple[ProblemSummary, ...]:
        """The problems of a family."""
        return tuple(problem for problem in self.problems if problem.family == family)

    def to_frame(self, of: Literal["runs", "trajectory", "targets"] = "runs") -> "pd.DataFrame":
        """The runs as a table.

        Args:
            of: Which table: of runs, of their improvements, or of runs and targets as in runs.csv.

        Returns:
            Rows in the order of problem, algorithm and seed. Of "runs" a row for each run: `problem`, `family`,
            `dimension`, `algorithm`, `seed`, `state` ("done" or "failed"), `reason`, `evaluations`, `seconds`,
            `processor_s`, `best` (lowest cost, infinite if none was found), `violation`, and of the problem `lowest`
            (the lowest cost known), `scale`; `excess` is (best - lowest) / scale. Of "trajectory" a row for each
            improvement: `problem`, `algorithm`, `seed`, `evaluations`, `seconds`, `cost`, `excess`. Of "targets" a row
            for each run and target: `problem`, `algorithm`, `seed`, `state`, `reason`, `tolerance`, `target` (its
            cost), `reached` ("yes" or "no"), `evaluations` and `seconds` to it (missing if it was not reached), and
            `run_evaluations`, `run_seconds`, `run_processor_s`, `run_best`, `run_violation` of the whole run.
        """
        runs = sorted(self.runs, key=lambda run: run.key)
        return FRAMES[of](runs, {problem.name: problem for problem in self.problems})

    def arrays(self, family: str) -> ResultArrays:
        """Runs on the problems of a family as arrays, without solvers that apply to none of them."""
        problems = self.of(family)
        taking_part = [name for name in self.solvers if any((one.name, name) not in self.refused for one in problems)]
        limits = {"budget": self.budget, "time_limit_s": self.time_limit_s}
        return ResultArrays.of(self.runs, problems, taking_part, self.seeds, **limits)

    def labelled(self, labels: Mapping[str, str]) -> "BenchmarkResult":
        """The same with other names for solvers; who has none keeps the old one."""
        new = {name: labels.get(name, name) for name in self.solvers}
        return replace(
            self,
            problems=tuple(replace(one, found_by=new.get(one.found_by, one.found_by)) for one in self.problems),
            solvers={new[name]: title for name, title in self.solvers.items()},
            refused={(problem, new[name]): reason for (problem, name), reason in self.refused.items()},
            dropped={new[name]: count for name, count in self.dropped.items()},
            runs=tuple(replace(run, algorithm=new[run.algorithm]) for run in self.runs),
        )
