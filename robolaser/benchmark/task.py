"""A run that is to be made, as it goes to another process or machine."""

from dataclasses import dataclass
from typing import final

import numpy as np

from robolaser.benchmark.convergence import Course
from robolaser.benchmark.single_run import FAILED, Run


@final
@dataclass(frozen=True)
class Task:
    """Who is to search, where and on what terms.

    Attributes:
        problem: Name of the question.
        algorithm: The contestant, as it was asked for.
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

    def failed(self, reason: str, *, seconds: float = 0.0) -> Run:
        """The run of which nothing is known but why it failed, and after how long."""
        nothing = Course(np.empty(0, np.int64), np.empty(0), np.empty(0))
        return Run(self.problem, self.algorithm, self.seed, FAILED, reason, 0, seconds, 0.0, nothing)
