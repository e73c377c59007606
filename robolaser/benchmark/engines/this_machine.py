"""Runs on the cores of this machine."""

import math
import os
from concurrent.futures import CancelledError, Future, ThreadPoolExecutor
from pathlib import Path
from typing import final

from robolaser.benchmark.engines.engine import Engine, Payload, digest
from robolaser.benchmark.engines.job import B, Job, P, R
from robolaser.benchmark.engines.worker_pool import WorkerPool
from robolaser.benchmark.engines.worker_process import ClientProcess

CPU_LIMIT = Path("/sys/fs/cgroup/cpu.max")
"""Where Linux states how much processor time a container has: quota and period [µs]."""


@final
class ThisMachine(Engine):
    """Runs in worker processes of this machine, one on each core by default, each watched by a thread."""

    label = "this machine"

    def __init__(self, jobs: int | None = None) -> None:
        self._jobs = usable_cores() if jobs is None else jobs
        self._pool = WorkerPool(ClientProcess.here())
        self._threads = ThreadPoolExecutor(self._jobs)

    @property
    def workers(self) -> int:
        """Runs at a time."""
        return self._jobs

    def share(self, payload: bytes) -> Payload:
        """Keep it in memory: workers fetch it from this process."""
        return Payload(digest(payload), payload)

    def submit(self, job: Job[R, P, B], payload: Payload) -> Future[R]:
        """Have a job done."""
        return self._threads.submit(self._do, job, payload)

    def close(self) -> None:
        """Kill whatever runs."""
        self._pool.close()
        self._threads.shutdown(cancel_futures=True)

    def _do(self, job: Job[R, P, B], payload: Payload) -> R:
        made = self._pool.do(job, payload.digest, lambda: payload.content)
        if self._pool.closed:
            raise CancelledError
        return made


def usable_cores() -> int:
    """Cores that this process may use: by its affinity and, in a container, by its share of processor time."""
    cores = len(os.sched_getaffinity(0)) if hasattr(os, "sched_getaffinity") else os.cpu_count() or 1
    quota, period = CPU_LIMIT.read_text().split() if CPU_LIMIT.exists() else ("max", "1")
    return cores if quota == "max" else min(cores, math.ceil(int(quota) / int(period)))
