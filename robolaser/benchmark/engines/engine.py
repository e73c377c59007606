"""The abstract engine, which makes runs."""

import hashlib
from abc import ABC, abstractmethod
from concurrent.futures import Future
from dataclasses import dataclass
from types import TracebackType
from typing import Any, Self, final

from robolaser.benchmark.single_run import BenchmarkRun
from robolaser.benchmark.task import Task
from robolaser.errors import BenchmarkError


@final
@dataclass(frozen=True, eq=False)
class Payload:
    """A pickled problem spec, already where the runs are made.

    Attributes:
        digest: Identifies it.
        content: The engine's own business.
    """

    digest: str
    content: Any


class EngineLost(BenchmarkError):
    """The engine failed in the middle of a benchmark; the runs made so far are safe."""


class Engine(ABC):
    """Makes runs, several at a time, each in a process of its own; every engine makes the same runs.

    Attributes:
        label: Its name in results.
    """

    label: str

    @property
    @abstractmethod
    def workers(self) -> int:
        """Runs at a time, now; at least one."""

    @property
    def empty(self) -> bool:
        """Whether there are no workers yet: runs wait for the first."""
        return False

    @abstractmethod
    def share(self, payload: bytes) -> Payload:
        """Bring the pickled source of a problem to where runs are made, once for all of them."""

    @abstractmethod
    def submit(self, task: Task, payload: Payload) -> Future[BenchmarkRun]:
        """Have a run made. A solver that fails in whatever way gives a failed run, not an exception.

        Returns:
            The run to come; cancelled if the engine is closed before, `EngineLost` if the engine fails.
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
