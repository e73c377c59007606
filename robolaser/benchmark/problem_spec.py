"""The source of a problem."""

from collections.abc import Callable
from dataclasses import dataclass
from typing import final

from robolaser.benchmark.problem import BenchmarkProblem


@final
@dataclass(frozen=True, eq=False)
class ProblemSpec:
    """Builds a problem; unlike the problem, whose functions cannot be pickled, it can be sent to another process.

    Attributes:
        name: Name of the problem.
        problem: Builds it.
    """

    name: str
    problem: Callable[[], BenchmarkProblem]
