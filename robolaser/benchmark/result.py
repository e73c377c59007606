"""A comparison as it stands: questions, contestants and every run so far."""

from collections.abc import Mapping
from dataclasses import dataclass
from typing import final

from robolaser.benchmark.results_array import Tally
from robolaser.benchmark.single_run import FAILED, Run


@final
@dataclass(frozen=True)
class Contested:
    """A question, and the lowest cost that anybody found.

    Attributes:
        name: Of the question.
        title: What it is, for a person.
        family: See `Question`.
        dimension: Variables to be found.
        unit: Of the cost.
        scale: What tolerances of targets are measured in: the lowest cost itself, unless it is next to nothing.
        best: The lowest cost known.
        found_by: Who found it: a contestant's name, "theory", or "robolaser's own search".
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
    """What the comparison itself took, over all its sessions if it was resumed.

    Attributes:
        engine: What the runs went through last: "this machine" or the address of a Dask scheduler.
        workers: Runs at a time, last.
        seconds: Wall time.
        capacity_s: Wall time that all workers had together.
        busy_s: How much of it went into runs.
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
class Comparison:
    """All that was asked, and all that came of it so far.

    Attributes:
        problems: What was contested.
        contestants: Title of each by name, in the order asked for.
        refused: Why a contestant has nothing to say on a problem, by (problem, contestant).
        seeds: Of the runs: each contestant has a run with each on each problem.
        budget: Evaluations a run may spend.
        time_limit_s: Wall time a run may take [s].
        runs: Those that were made.
        effort: What it took.
    """

    problems: tuple[Contested, ...]
    contestants: Mapping[str, str]
    refused: Mapping[tuple[str, str], str]
    seeds: tuple[int, ...]
    budget: int
    time_limit_s: float
    runs: tuple[Run, ...]
    effort: Effort

    @property
    def families(self) -> tuple[str, ...]:
        """Families of the problems, in order."""
        return tuple(dict.fromkeys(problem.family for problem in self.problems))

    @property
    def wanted(self) -> int:
        """Runs that were asked for."""
        return (len(self.problems) * len(self.contestants) - len(self.refused)) * len(self.seeds)

    @property
    def failures(self) -> tuple[Run, ...]:
        """Runs that failed."""
        return tuple(run for run in self.runs if run.state == FAILED)

    def of(self, family: str) -> tuple[Contested, ...]:
        """The problems of a family."""
        return tuple(problem for problem in self.problems if problem.family == family)

    def tally(self, family: str) -> Tally:
        """Runs on the problems of a family as arrays; contestants that have nothing to say on any are left out."""
        problems = self.of(family)
        return Tally.of(
            self.runs,
            problems=[problem.name for problem in problems],
            algorithms=[
                name
                for name in self.contestants
                if any((problem.name, name) not in self.refused for problem in problems)
            ],
            seeds=self.seeds,
            best=[problem.best for problem in problems],
            scale=[problem.scale for problem in problems],
            budget=self.budget,
            time_limit_s=self.time_limit_s,
        )
