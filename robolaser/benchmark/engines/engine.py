"""The abstract engine, which has jobs done."""

import hashlib
from abc import ABC, abstractmethod
from concurrent.futures import Future
from dataclasses import dataclass
from types import TracebackType
from typing import Any, Self, final

from robolaser.benchmark.engines.job import B, Job, P, R
from robolaser.errors import BenchmarkError


@final
@dataclass(frozen=True, eq=False)
class Payload:
    """What jobs have in common, pickled, already where they are done: a problem's spec."""

    digest: str  # identifies it
    content: Any  # the engine's own business


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
    def share(self, payload: bytes) -> Payload:
        """Bring what jobs have in common to where they are done, once for all of them."""

    @abstractmethod
    def submit(self, job: Job[R, P, B], payload: Payload) -> Future[R]:
        """Have a job done. Work that fails in whatever way gives the job's result of a failure, not an exception.

        Returns:
            The result to come; cancelled if the engine is closed before, `EngineLost` if the engine fails.
        """

    @abstractmethod
    def close(self) -> None:
        """Kill whatever runs, at once."""

    def __enter__(self) -> Self:
        return self

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        self.close()


def digest(payload: bytes) -> str:
    """What identifies a payload."""
    return hashlib.sha256(payload).hexdigest()
