"""Runs in worker processes, watched from outside: one that hangs, dies or eats memory harms nobody else."""

import threading
import time
from collections.abc import Callable
from typing import final

from robolaser.benchmark.engines.job import B, Job, P, R
from robolaser.benchmark.engines.worker_process import ClientProcess, WorkerProcess, WorkerTimeout

ATTEMPTS = 2
"""A worker that is killed from outside is not the run's fault; if the next one dies too, the run has failed."""


@final
class WorkerPool:
    """Worker processes of a program for as many runs as are wanted at the same time; each is kept for the next run."""

    def __init__(self, program: ClientProcess) -> None:
        self._program = program
        self._lock = threading.Lock()
        self._idle: list[WorkerProcess] = []
        self._busy: set[WorkerProcess] = set()
        self._slow_to_start: set[tuple[str, str]] = set()
        self._closed = False

    @property
    def closed(self) -> bool:
        """Whether it was closed: it makes no more runs."""
        return self._closed

    @property
    def workers(self) -> tuple[WorkerProcess, ...]:
        """All its processes."""
        with self._lock:
            return (*self._idle, *self._busy)

    def do(self, job: Job[R, P, B], digest: str, payload: Callable[[], bytes]) -> R:
        """Have a job done, from any thread; its pickled payload is asked for only if the worker does not have it yet.

        The result is that of a failure if the worker did not return in time, or died and so did the next one.
        """
        reason, seconds = "stopped", 0.0
        deaths = 0
        while deaths < ATTEMPTS and (worker := self._taken()) is not None:
            reusable, sent = False, time.monotonic()
            warm_up = (digest, job.kind) not in self._slow_to_start
            try:
                made, reusable = worker.do(job, digest, payload, self._program, warm_up=warm_up)
                done: R = made
                return done
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
            self._closed = True
            for worker in (*self._idle, *self._busy):
                worker.kill()
            self._idle.clear()

    def _taken(self) -> WorkerProcess | None:
        """A worker that is free or new; None when the pool is closed."""
        with self._lock:
            if self._closed:
                return None
            while self._idle and not self._idle[-1].alive:
                self._idle.pop().kill()
            worker = self._idle.pop() if self._idle else WorkerProcess()
            self._busy.add(worker)
            return worker

    def _returned(self, worker: WorkerProcess, *, reusable: bool) -> None:
        with self._lock:
            self._busy.discard(worker)
            if reusable and not self._closed:
                self._idle.append(worker)
                return
        worker.kill()
