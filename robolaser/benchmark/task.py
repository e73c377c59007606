"""A run that is to be made, as it is sent to another process or machine."""

from dataclasses import dataclass
from typing import final

import numpy as np

from robolaser.benchmark.convergence import ConvergenceTrace
from robolaser.benchmark.single_run import FAILED, BenchmarkRun, Key


@final
@dataclass(frozen=True)
class Task:
    """Which solver is to run on which problem, with which seed and limits.

    Attributes:
        problem: Name of the problem.
        algorithm: The solver, as the user named it.
        seed: Of the run.
        budget: Evaluations it may spend.
        time_limit_s: Wall time it may take [s].
        memory_limit_b: Memory it may take beyond what its process needs anyway [B].
    """

    problem: str
    algorithm: str
    seed: int
    budget: int
    time_limit_s: float
    memory_limit_b: int

    @property
    def key(self) -> Key:
        """What identifies its run."""
        return self.problem, self.algorithm, self.seed

    def failed(self, reason: str, *, seconds: float = 0.0) -> BenchmarkRun:
        """A failed run of which only the reason and the time are known."""
        nothing = ConvergenceTrace(np.empty(0, np.int64), np.empty(0), np.empty(0))
        return BenchmarkRun(self.problem, self.algorithm, self.seed, FAILED, reason, 0, seconds, 0.0, nothing)
