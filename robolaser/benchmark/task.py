"""A run that is to be made, as it is sent to another process or machine."""

import pickle
from dataclasses import dataclass, replace
from typing import final

import numpy as np

from robolaser.benchmark.convergence import ConvergenceTrace
from robolaser.benchmark.engines.job import Job
from robolaser.benchmark.problem import BenchmarkProblem, ProblemSpec
from robolaser.benchmark.single_run import FAILED, WARM_UP, BenchmarkRun, Key, run


@final
@dataclass(frozen=True)
class Task(Job[BenchmarkRun, ProblemSpec, BenchmarkProblem]):
    """Which solver is to run on which problem, with which seed and limits."""

    problem: str
    algorithm: str  # as the user named it
    seed: int
    budget: int  # evaluations it may spend
    time_limit_s: float
    memory_limit_b: int  # beyond what its process needs anyway
    solver: bytes = b""  # pickled, where no other process could find it by its name

    @property
    def key(self) -> Key:
        """What identifies its run."""
        return self.problem, self.algorithm, self.seed

    @property
    def kind(self) -> str:
        """Runs of one solver warm up alike."""
        return self.algorithm

    def prepared(self, payload: ProblemSpec) -> BenchmarkProblem:
        """The problem, built."""
        return payload.problem()

    def warm_up(self, prepared: BenchmarkProblem) -> None:
        """An uncounted first run, in which a process imports and compiles what it needs."""
        self._run(prepared, min(WARM_UP, self.budget))

    def done(self, prepared: BenchmarkProblem) -> BenchmarkRun:
        """The run."""
        return self._run(prepared, self.budget)

    def failed(self, reason: str, *, seconds: float = 0.0) -> BenchmarkRun:
        """A failed run of which only the reason and the time are known."""
        nothing = ConvergenceTrace(np.empty(0, np.int64), np.empty(0), np.empty(0))
        return BenchmarkRun(self.problem, self.algorithm, self.seed, FAILED, reason, 0, seconds, 0.0, nothing)

    def _run(self, problem: BenchmarkProblem, budget: int) -> BenchmarkRun:
        from robolaser.benchmark.solvers import find  # noqa: PLC0415 - with it come pymoo and SciPy

        solver = pickle.loads(self.solver) if self.solver else find(self.algorithm)
        made = run(problem, solver, seed=self.seed, budget=budget, time_limit_s=self.time_limit_s)
        return replace(made, problem=self.problem, algorithm=self.algorithm)
