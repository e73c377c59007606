"""Runs on the cores of this machine."""

import hashlib
import math
import os
import threading
import time
from collections.abc import Callable
from concurrent.futures import CancelledError, Future, ThreadPoolExecutor
from pathlib import Path
from typing import Any, final

from robolaser.benchmark.engines.engine import Engine, Job
from robolaser.benchmark.engines.worker_process import WorkerProcess, WorkerTimeout, import_paths

ATTEMPTS = 2
"""A worker that is killed from outside is not the run's fault; if the next one dies too, the run has failed."""
CPU_LIMIT = Path("/sys/fs/cgroup/cpu.max")
"""Where Linux states how much processor time a container has: quota and period [µs]."""


@final
class ThisMachine(Engine):
    """Runs in worker processes of this machine, one on each core by default, each watched by a thread."""

    label = "this machine"

    def __init__(self, jobs: int | None = None) -> None:
        self._jobs = usable_cores() if jobs is None else jobs
        self._pool = WorkerPool()
        self._threads = ThreadPoolExecutor(self._jobs)

    @property
    def workers(self) -> int:
        """Runs at a time."""
        return self._jobs

    def share(self, payload: bytes) -> tuple[str, bytes]:
        """Keep it in memory, with what identifies it: workers fetch it from this process."""
        return hashlib.sha256(payload).hexdigest(), payload

    def submit(self, job: Job, shared: tuple[str, bytes]) -> Future[Any]:
        """Have a job done."""
        return self._threads.submit(self._do, job, *shared)

    def close(self) -> None:
        """Kill whatever runs."""
        self._pool.close()
        self._threads.shutdown(cancel_futures=True)

    def _do(self, job: Job, digest: str, payload: bytes) -> Any:
        made = self._pool.do(job, digest, lambda: payload)
        if self._pool.closed:
            raise CancelledError
        return made


@final
class WorkerPool:
    """Worker processes for as many runs as are wanted at the same time; each is kept for the next run.

    They are watched from outside: one that hangs, dies or eats memory harms nobody else.

    Args:
        paths: Import paths of the program that wants the runs, this one by default; workers look there too, last.
    """

    def __init__(self, paths: tuple[str, ...] | None = None) -> None:
        self.closed = False
        self._paths = import_paths() if paths is None else paths
        self._lock = threading.Lock()
        self._idle: list[WorkerProcess] = []
        self._busy: set[WorkerProcess] = set()
        self._slow_to_start: set[tuple[str, str]] = set()

    @property
    def workers(self) -> tuple[WorkerProcess, ...]:
        """All its processes."""
        with self._lock:
            return (*self._idle, *self._busy)

    def do(self, job: Job, digest: str, payload: Callable[[], bytes]) -> Any:
        """Have a job done, from any thread; its pickled payload is asked for only if the worker does not have it yet.

        The result is that of a failure if the worker did not return in time, or died and so did the next one.
        """
        reason, seconds, deaths = "stopped", 0.0, 0
        while deaths < ATTEMPTS and (worker := self._taken()) is not None:
            reusable, sent = False, time.monotonic()
            warm_up = (digest, job.kind) not in self._slow_to_start
            try:
                made, reusable = worker.do(job, digest, payload, self._paths, warm_up=warm_up)
                return made
            except WorkerTimeout as timeout:
                if worker.began is None:
                    self._slow_to_start.add((digest, job.kind))  # its other runs are not waited for that long
                phase = "" if worker.began else " of its uncounted first evaluations"
                reason = f"never came back within {timeout.allowed_s:g} s{phase}; killed"
                return job.failed(reason, seconds=time.monotonic() - (worker.began or sent))
            except (EOFError, OSError):
                reason, seconds = worker.autopsy(), time.monotonic() - (worker.began or sent)
                if worker.heard or not worker.used:  # else it may have died between two runs
                    deaths += 1
            finally:
                self._returned(worker, reusable=reusable)
        return job.failed(reason, seconds=seconds)

    def close(self) -> None:
        """Kill all workers at once, whatever they run, and start no others."""
        with self._lock:
            self.closed = True
            for worker in (*self._idle, *self._busy):
                worker.kill()
            self._idle.clear()

    def _taken(self) -> WorkerProcess | None:
        """A worker that is free or new; None when the pool is closed."""
        with self._lock:
            if self.closed:
                return None
            while self._idle and not self._idle[-1].alive:
                self._idle.pop().kill()
            worker = self._idle.pop() if self._idle else WorkerProcess()
            self._busy.add(worker)
            return worker

    def _returned(self, worker: WorkerProcess, *, reusable: bool) -> None:
        with self._lock:
            self._busy.discard(worker)
            if reusable and not self.closed:
                self._idle.append(worker)
                return
        worker.kill()


def usable_cores() -> int:
    """Cores that this process may use: by its affinity and, in a container, by its share of processor time."""
    cores = len(os.sched_getaffinity(0)) if hasattr(os, "sched_getaffinity") else os.cpu_count() or 1
    quota, period = CPU_LIMIT.read_text().split() if CPU_LIMIT.exists() else ("max", "1")
    return cores if quota == "max" else min(cores, math.ceil(int(quota) / int(period)))
