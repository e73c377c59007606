"""Executors of runs: monitored processes of this machine, or the workers of a Dask cluster."""

import multiprocessing
import os
import signal
import sys
import threading
from collections.abc import Callable, Iterator
from concurrent.futures import BrokenExecutor, Executor, Future, ProcessPoolExecutor, ThreadPoolExecutor
from contextlib import contextmanager, suppress
from dataclasses import dataclass
from types import ModuleType
from typing import Any, final

from robolaser.errors import BenchmarkError, UsageError
from robolaser.plugins import extra

PACKAGES = ("robolaser", "numpy", "scipy", "pymoo")  # whose versions must agree on all machines
CONNECT_S = 10.0
_START = threading.Lock()


@final
@dataclass(frozen=True)
class Engine:
    """An executor of runs."""

    executor: Executor
    label: str
    workers: int  # runs at a time


class WorkerLost(BenchmarkError):
    """The process of a call died, or was killed after its time."""


@contextmanager
def engine_of(jobs: int | None, scheduler: str | None, *, time_limit_s: float | None) -> Iterator[Engine]:
    """Processes of this machine, one on each core by default, or the workers of a Dask cluster at tcp://HOST:PORT.

    A process of this machine that takes longer than the time limit for one call is killed.

    Raises:
        UsageError: `jobs` is below 1.
        BenchmarkError: The cluster does not answer, has no workers, or has other versions of packages.
        DependencyMissing: Dask is not installed.
    """
    if jobs is not None and jobs < 1:
        raise UsageError(f"compare: jobs is {jobs!r}, expected at least 1.")
    if scheduler is None:
        cores = len(os.sched_getaffinity(0)) if hasattr(os, "sched_getaffinity") else os.cpu_count() or 1
        with Processes(jobs or cores, time_limit_s) as processes:
            yield Engine(processes, "this machine", jobs or cores)
        return
    dask = extra("distributed", "A cluster needs Dask, which is not installed: pip install 'robolaser[dask]'.")
    try:
        dask.comm.get_address_host_port(scheduler, strict=True)  # a client refuses it only with printed errors
        client = dask.Client(scheduler, timeout=CONNECT_S, set_as_default=False)
    except (OSError, ValueError) as error:
        raise BenchmarkError(
            f"No Dask scheduler answers at {scheduler} ({error}). Start one: dask scheduler."
        ) from None
    with client:
        try:
            client.get_versions(check=True, packages=list(PACKAGES))
        except ValueError as error:
            raise BenchmarkError(f"The workers at {scheduler} have other versions than this machine. {error}") from None
        workers = sum(client.nthreads().values())
        if not workers:
            raise BenchmarkError(f"The Dask cluster at {scheduler} has no workers: dask worker {scheduler}.")
        yield Engine(client.get_executor(pure=False), f"Dask at {scheduler}", workers)


@final
class Processes(Executor):
    """One process for each of several threads: a crashed or blocked process ends no other call.

    A process that takes longer than the time limit for a call is killed; None: never.
    """

    def __init__(self, workers: int, time_limit_s: float | None = None) -> None:
        self._threads, self._limit_s = ThreadPoolExecutor(workers), time_limit_s
        self._own, self._closed = threading.local(), threading.Event()
        self._processes: set[int] = set()

    def submit(self, fn: Callable[..., Any], /, *args: Any, **kwargs: Any) -> Future[Any]:
        """Call a function in a process, with pickled arguments. `WorkerLost` if the process dies or is killed."""
        return self._threads.submit(self._called, fn, *args, **kwargs)

    def shutdown(self, wait: bool = True, *, cancel_futures: bool = False) -> None:  # noqa: FBT001, FBT002 - Executor's
        """End all processes at once."""
        self._closed.set()
        for pid in list(self._processes):
            _kill(pid)
        self._threads.shutdown(wait=wait, cancel_futures=True)

    def _called(self, fn: Callable[..., Any], *args: Any, **kwargs: Any) -> Any:
        if getattr(self._own, "pool", None) is None:
            self._own.pool, self._own.pid = self._started()
        try:
            return self._own.pool.submit(fn, *args, **kwargs).result(self._limit_s)
        except TimeoutError:
            self._end()
            raise WorkerLost(f"it hung, and was killed after {self._limit_s:g} s") from None
        except BrokenExecutor:
            self._end()
            raise WorkerLost("its process died: it ended itself, crashed, or the machine ran out of memory") from None

    def _started(self) -> tuple[ProcessPoolExecutor, int]:
        if self._closed.is_set():
            raise WorkerLost("it was not begun")
        pool = ProcessPoolExecutor(1, multiprocessing.get_context("spawn"), _begin)
        with _START, _main_out_of_sight():
            pid: int = pool.submit(os.getpid).result()
        self._processes.add(pid)
        if self._closed.is_set():  # during its start, when it could not be ended
            _kill(pid)
        return pool, pid

    def _end(self) -> None:
        _kill(self._own.pid)
        self._processes.discard(self._own.pid)
        self._own.pool.shutdown(wait=False, cancel_futures=True)
        self._own.pool = None


def _begin() -> None:
    """Ignore Ctrl-C, end with the parent, and use one core."""
    from threadpoolctl import threadpool_limits  # noqa: PLC0415 - only processes need it

    signal.signal(signal.SIGINT, signal.SIG_IGN)
    parent = multiprocessing.parent_process()

    def end_with_the_parent() -> None:
        if parent is not None:
            parent.join()
        os._exit(1)

    threading.Thread(target=end_with_the_parent, daemon=True).start()
    import numpy  # noqa: F401, PLC0415 - whose threads are limited

    threadpool_limits(1)
    sys.path.insert(0, os.getcwd())


@contextmanager
def _main_out_of_sight() -> Iterator[None]:
    """Prevent new processes from running the user's script again: its contents are pickled with each call."""
    main = sys.modules["__main__"]
    sys.modules["__main__"] = ModuleType("__main__")
    try:
        yield
    finally:
        sys.modules["__main__"] = main


def _kill(pid: int) -> None:
    with suppress(ProcessLookupError, PermissionError):
        os.kill(pid, signal.SIGKILL)
