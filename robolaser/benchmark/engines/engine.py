"""What makes runs."""

import hashlib
from abc import ABC, abstractmethod
from concurrent.futures import Future
from dataclasses import dataclass
from types import TracebackType
from typing import Any, Self, final

from robolaser.benchmark.single_run import Run
from robolaser.benchmark.task import Task


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


class Engine(ABC):
    """Makes runs, several at a time, each guarded in a process of its own; the same runs whichever engine it is.

    Attributes:
        label: What it is called in results.
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
        """Bring the pickled source of a question to where runs are made, once for all of them."""

    @abstractmethod
    def submit(self, task: Task, payload: Payload) -> Future[Run]:
        """Have a run made. A contestant that fails in whatever way makes a failed run, no exception.

        Returns:
            The run to come; cancelled if the engine is closed before, and RobolaserError if the engine is lost.
        """

    @abstractmethod
    def close(self) -> None:
        """Stop whatever runs, at once."""

    def __enter__(self) -> Self:
        return self

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        self.close()


def digest(payload: bytes) -> str:
    """What a payload is known by."""
    return hashlib.sha256(payload).hexdigest()
