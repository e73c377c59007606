"""The abstract engine, which has jobs done, and the abstract job: work for a process that is watched from outside."""

from abc import ABC, abstractmethod
from concurrent.futures import Future
from typing import Any, Self

from robolaser.errors import BenchmarkError


class Job(ABC):
    """Work with a payload, which a process prepares once and keeps.

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
    def prepared(self, payload: Any) -> Any:
        """Make of the payload what all jobs with it need."""

    def warm_up(self, prepared: Any) -> None:
        """Import and compile what the work needs, before the clock runs."""
        return

    @abstractmethod
    def done(self, prepared: Any) -> Any:
        """Do the work."""

    @abstractmethod
    def failed(self, reason: str, *, seconds: float = 0.0) -> Any:
        """The result of work that failed, after so many seconds."""


class EngineLost(BenchmarkError):
    """The engine failed in the middle of a benchmark; the runs made so far are safe."""


class Engine(ABC):
    """Has jobs done, several at a time, each in a process of its own; every engine gives the same results.

    Attributes:
        label: Its name in results.
    """

    label: str

    @property
    @abstractmethod
    def workers(self) -> int:
        """Jobs at a time, now; at least one."""

    @property
    def empty(self) -> bool:
        """Whether there are no workers yet: jobs wait for the first."""
        return False

    @abstractmethod
    def share(self, payload: bytes) -> Any:
        """Bring what jobs have in common, pickled, to where they are done, once for all of them."""

    @abstractmethod
    def submit(self, job: Job, shared: Any) -> Future[Any]:
        """Have a job done. Work that fails in whatever way gives the job's result of a failure, not an exception.

        Args:
            job: The job.
            shared: What `share` made of its payload.

        Returns:
            The result to come; cancelled if the engine is closed before, `EngineLost` if the engine fails.
        """

    @abstractmethod
    def close(self) -> None:
        """Kill whatever runs, at once."""

    def __enter__(self) -> Self:
        return self

    def __exit__(self, *error: object) -> None:
        self.close()
