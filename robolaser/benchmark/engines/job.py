"""The abstract job: what a worker process is asked to do."""

from abc import ABC, abstractmethod
from typing import Any, Generic, TypeVar

R = TypeVar("R")
P = TypeVar("P")
B = TypeVar("B")


class Job(ABC, Generic[R, P, B]):
    """Work for a process that is watched from outside; its result is R, from a payload P that is prepared once as B.

    Attributes:
        time_limit_s: Wall time it may take [s].
        memory_limit_b: Memory it may take beyond what its process needs anyway [B].
    """

    time_limit_s: float
    memory_limit_b: int

    @property
    @abstractmethod
    def kind(self) -> str:
        """Jobs of one kind warm up alike: the second of them in a process need not."""

    @abstractmethod
    def prepared(self, payload: P) -> B:
        """Make of the payload what all jobs with it need; a process keeps it."""

    def warm_up(self, prepared: B) -> None:
        """Import and compile what the work needs, before the clock runs."""
        return

    @abstractmethod
    def done(self, prepared: B) -> R:
        """Do the work."""

    @abstractmethod
    def failed(self, reason: str, *, seconds: float = 0.0) -> R:
        """The result of work that failed, after so many seconds."""


AnyJob = Job[Any, Any, Any]
