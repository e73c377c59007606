"""The abstract source of a problem."""

from abc import ABC, abstractmethod

from robolaser.benchmark.problem import BenchmarkProblem


class ProblemSpec(ABC):
    """Builds a problem; unlike the problem, whose functions cannot be pickled, it can be sent to another process.

    Attributes:
        name: Name of the problem.
    """

    name: str

    @abstractmethod
    def problem(self) -> BenchmarkProblem:
        """Build the problem."""
