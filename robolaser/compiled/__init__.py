"""Loops that a compiler makes as fast as the machine goes, and how they share its cores.

The modules here hold numba's functions on plain arrays; each has a readable twin in NumPy beside its caller, which
steps in where there is no compiler. Both agree to rounding.
"""

import importlib.util
import os
from collections.abc import Callable, Iterable
from concurrent.futures import ThreadPoolExecutor
from functools import cache

SWITCH = "ROBOLASER_COMPILE"
"""Environment variable: `0` does without the compiler."""


@cache
def available() -> bool:
    """Whether loops are compiled: numba is installed, and nobody said no."""
    return os.environ.get(SWITCH, "1") != "0" and importlib.util.find_spec("numba") is not None


@cache
def cores() -> int:
    """Cores that loops may use: all of this process, or as many as `OMP_NUM_THREADS` says."""
    told = os.environ.get("OMP_NUM_THREADS", "")
    if told.isdigit() and int(told) > 0:
        return int(told)
    return len(os.sched_getaffinity(0)) if hasattr(os, "sched_getaffinity") else os.cpu_count() or 1


def share_out(tasks: Iterable[Callable[[], None]]) -> None:
    """Do all tasks on as many threads as there are cores, this one among them.

    They must let go of Python's lock to gain by it. A thread that has not woken up before nothing is left to do is not
    waited for.
    """
    waiting = list(tasks)
    left = iter(waiting)

    def work() -> None:
        for task in left:
            task()

    others = min(cores(), len(waiting)) - 1
    helping = [_threads(os.getpid()).submit(work) for _ in range(others)]
    work()
    for helper in helping:
        if not helper.cancel():
            helper.result()


@cache
def _threads(process: int) -> ThreadPoolExecutor:
    """The threads of a process; one that was forked off needs its own."""
    return ThreadPoolExecutor(cores(), thread_name_prefix="robolaser")
