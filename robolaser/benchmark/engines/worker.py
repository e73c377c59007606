"""The process in which jobs are done: what they do to it harms no other. `worker_process` starts it."""

import os
import pickle
import signal
import sys
import threading
from collections.abc import Iterator
from contextlib import contextmanager
from multiprocessing.connection import Connection
from pathlib import Path
from typing import Any, final

from robolaser.benchmark.engines.engine import Job

try:
    import resource
except ImportError:  # pragma: no cover - Windows
    resource = None  # type: ignore[assignment]

NEEDED, READY, BEGUN = "the problem is needed", "the problem is there", "the clock runs"
"""Messages of a worker before its answer."""
IDLE_S = 600.0
"""A worker without a job for so long exits."""
SWOLLEN = 0.5
"""A worker that has grown by more than this share of a run's memory limit is not reused."""


@final
class Runner:
    """Does jobs, and keeps what they need and what they compiled for the next."""

    def __init__(self, parent: Connection) -> None:
        self._parent = parent
        self._prepared: dict[str, Any] = {}
        self._warm: set[tuple[str, str]] = set()

    def answer(self, job: Job, digest: str, *, warm_up: bool) -> tuple[Any, bool]:
        """Do a job; also return whether this process is fit for another."""
        try:
            if digest not in self._prepared:
                self._parent.send(NEEDED)
                self._prepared[digest] = job.prepared(pickle.loads(self._parent.recv_bytes()))
            prepared = self._prepared[digest]
            self._parent.send(READY)
            used = _address_space()
            with _limited(used + job.memory_limit_b):
                if warm_up and (digest, job.kind) not in self._warm:
                    job.warm_up(prepared)
                    self._warm.add((digest, job.kind))
                self._parent.send(BEGUN)
                made = job.done(prepared)
            return made, _address_space() - used < SWOLLEN * job.memory_limit_b
        except BaseException as error:  # sys.exit in a solver is its failure too
            return job.failed(f"{type(error).__name__}: {error}".removesuffix(": ")), False


def main() -> None:
    """Do jobs until the parent sends no more."""
    talk, life = map(int, sys.argv[1:])
    _die_with(life)
    parent = Connection(talk)
    runner = Runner(parent)
    while parent.poll(IDLE_S):
        digest, paths, warm_up, job = parent.recv()
        sys.path.extend(path for path in paths if path not in sys.path)
        parent.send(runner.answer(pickle.loads(job), digest, warm_up=warm_up))


def _die_with(life: int) -> None:
    """Die at once, with all that was started, when the other end of a pipe is closed."""
    if sys.platform == "linux":  # even while a solver does not let go of the interpreter
        import fcntl  # noqa: PLC0415

        signal.signal(signal.SIGIO, signal.SIG_DFL)
        fcntl.fcntl(life, fcntl.F_SETOWN, -os.getpgrp())
        fcntl.fcntl(life, fcntl.F_SETFL, fcntl.fcntl(life, fcntl.F_GETFL) | os.O_ASYNC)
    threading.Thread(target=_end_at_end, args=(life,), daemon=True).start()


def _end_at_end(life: int) -> None:
    os.read(life, 1)
    os.killpg(os.getpgrp(), signal.SIGKILL)


@contextmanager
def _limited(address_space: int) -> Iterator[None]:
    """Limit the address space [B], where the platform says how much is used; more raises MemoryError."""
    if resource is None or not _address_space():
        yield
        return
    soft, hard = resource.getrlimit(resource.RLIMIT_AS)
    allowed = [limit for limit in (address_space, soft, hard) if limit != resource.RLIM_INFINITY]
    resource.setrlimit(resource.RLIMIT_AS, (min(allowed), hard))
    try:
        yield
    finally:
        resource.setrlimit(resource.RLIMIT_AS, (soft, hard))


def _address_space() -> int:
    """Address space of this process [B]; 0 where the platform does not say."""
    pages = Path("/proc/self/statm")
    return int(pages.read_text().split()[0]) * os.sysconf("SC_PAGE_SIZE") if pages.exists() else 0


if __name__ == "__main__":
    main()
