"""A benchmark's result: its problems, its solvers and every run so far."""

from collections.abc import Mapping
from dataclasses import dataclass
from typing import final

from robolaser.benchmark.result_arrays import ResultArrays
from robolaser.benchmark.single_run import FAILED, BenchmarkRun
from robolaser.results import Result


@final
@dataclass(frozen=True)
class ProblemSummary:
    """A problem, and the lowest cost that was ever found.

    Attributes:
        name: Name of the problem.
        title: A description for a person.
        family: See `BenchmarkProblem`.
        dimension: Number of variables.
        unit: Of the cost.
        scale: Unit of the targets' tolerances: the lowest cost itself, unless it is close to zero.
        best: The lowest cost known.
        found_by: A solver's name, "theory", or "robolaser's own search".
    """

    name: str
    title: str
    family: str
    dimension: int
    unit: str
    scale: float
    best: float
    found_by: str


@final
@dataclass(frozen=True)
class Effort:
    """What the benchmark itself took, over all its sessions if it was resumed.

    Attributes:
        engine: Where the last session's runs were made: "this machine" or the address of a Dask scheduler.
        workers: Runs at a time in the last session.
        seconds: Wall time.
        capacity_s: Wall time of all workers together.
        busy_s: The part of it that went into runs.
    """

    engine: str
    workers: int
    seconds: float
    capacity_s: float
    busy_s: float

    @property
    def busy(self) -> float:
        """Share of the workers' time that went into runs, 0 to 1."""
        return min(self.busy_s / self.capacity_s, 1.0) if self.capacity_s > 0 else 0.0


@final
@dataclass(frozen=True, eq=False)
class BenchmarkResult(Result):
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
    """

    problems: tuple[ProblemSummary, ...]
    solvers: Mapping[str, str]
    refused: Mapping[tuple[str, str], str]
    seeds: tuple[int, ...]
    budget: int
    time_limit_s: float
    runs: tuple[BenchmarkRun, ...]
    effort: Effort

    @property
    def families(self) -> tuple[str, ...]:
        """Families of the problems, in order."""
        return tuple(dict.fromkeys(problem.family for problem in self.problems))

    @property
    def wanted(self) -> int:
        """Number of runs that were planned."""
        return (len(self.problems) * len(self.solvers) - len(self.refused)) * len(self.seeds)

    @property
    def failures(self) -> tuple[BenchmarkRun, ...]:
        """The runs that failed."""
        return tuple(run for run in self.runs if run.state == FAILED)

    def of(self, family: str) -> tuple[ProblemSummary, ...]:
        """The problems of a family."""
        return tuple(problem for problem in self.problems if problem.family == family)

    def arrays(self, family: str) -> ResultArrays:
        """Runs on the problems of a family as arrays, without solvers that apply to none of them."""
        problems = self.of(family)
        return ResultArrays.of(
            self.runs,
            problems=[problem.name for problem in problems],
            algorithms=[
                name for name in self.solvers if any((problem.name, name) not in self.refused for problem in problems)
            ],
            seeds=self.seeds,
            best=[problem.best for problem in problems],
            scale=[problem.scale for problem in problems],
            budget=self.budget,
            time_limit_s=self.time_limit_s,
        )
