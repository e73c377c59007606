"""What takes part in a comparison."""

from abc import ABC, abstractmethod

from robolaser.benchmark.evaluator import Watch
from robolaser.benchmark.problem import Question


class Contestant(ABC):
    """A way to search, with all its settings.

    Attributes:
        name: As it was asked for, `de` or `rcga:b=2`; unique in a comparison.
        title: What it is, for a person.
    """

    name: str
    title: str

    @abstractmethod
    def search(self, watch: Watch, seed: int) -> None:
        """Look for the lowest cost until nothing is left to do or the watch ends it: `Over`, which is not to be caught.

        All randomness comes from `seed`: the same seed asks for the same candidates in the same order.

        Args:
            watch: The question; costs and residuals are asked from it, and from nowhere else.
            seed: Of this run, from 1.
        """

    def refuses(self, question: Question) -> str | None:
        """Why it has nothing to say on a question, if so."""
        return None
