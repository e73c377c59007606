"""Threads that share out the work of compiled loops."""

import os
from collections.abc import Callable, Iterable
from concurrent.futures import ThreadPoolExecutor
from functools import cache


@cache
def cores() -> int:
    """Cores that loops may use: all of this process, or as many as `OMP_NUM_THREADS` says."""
    limit = os.environ.get("OMP_NUM_THREADS", "")
    if limit.isdigit() and int(limit) > 0:
        return int(limit)
    return len(os.sched_getaffinity(0)) if hasattr(os, "sched_getaffinity") else os.cpu_count() or 1


def share_out(tasks: Iterable[Callable[[], None]]) -> None:
    """Run all tasks on as many threads as there are cores, this one among them.

    They must release Python's lock to gain by it. A thread that has not started when no task is left is not waited for.
    """
    waiting = list(tasks)
    left = iter(waiting)

    def work() -> None:
        for task in left:
            task()

    others = min(cores(), len(waiting)) - 1
    running = [_threads(os.getpid()).submit(work) for _ in range(others)]
    work()
    for thread in running:
        if not thread.cancel():
            thread.result()


@cache
def _threads(process: int) -> ThreadPoolExecutor:
    """The threads of a process; one that was forked off needs its own."""
    return ThreadPoolExecutor(cores(), thread_name_prefix="robolaser")
