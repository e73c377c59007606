"""Runs on the cores of this machine."""

import os
import shutil
import signal
import threading
import time
from collections import deque
from concurrent.futures import CancelledError, Future
from dataclasses import dataclass, field
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import final

from loky import cpu_count
from loky.process_executor import BrokenProcessPool, ProcessPoolExecutor

from robolaser.benchmark.engines.engine import Engine, Parcel, digest
from robolaser.benchmark.isolation import Origin, guarded
from robolaser.benchmark.payload import Task
from robolaser.benchmark.single_run import Run

LIVES = 5
"""So often a run begins anew because its worker was killed from outside."""
LOOK_S = 0.5
"""How often a worker looks whether its owner is still there."""


@final
@dataclass(eq=False)
class _Order:
    task: Task
    parcel: Parcel
    future: Future[Run] = field(default_factory=Future)
    lives: int = LIVES


@final
class ThisMachine(Engine):
    """Runs in processes of this machine.

    A killed worker breaks loky's whole pool. So no more is given to it than it has workers: what is lost with it are
    the runs under way, and they begin anew in a new pool.

    Args:
        jobs: Runs at a time; one on each core by default.
    """

    label = "this machine"

    def __init__(self, jobs: int | None = None) -> None:
        self._jobs = cpu_count() if jobs is None else jobs
        self._origin = Origin.here()
        self._folder = TemporaryDirectory(prefix="robolaser-")
        self._lock = threading.RLock()
        self._waiting: deque[_Order] = deque()
        self._flying: dict[Future[Run], _Order] = {}
        self._pool = self._new_pool()
        self._closed = False

    @property
    def workers(self) -> int:
        """Runs at a time."""
        return self._jobs

    def share(self, payload: bytes) -> Parcel:
        """Put it in a file."""
        name = digest(payload)
        path = Path(self._folder.name) / name
        if not path.exists():
            path.write_bytes(payload)
        return Parcel(name, path)

    def submit(self, task: Task, parcel: Parcel) -> Future[Run]:
        """Have a run made."""
        order = _Order(task, parcel)
        with self._lock:
            self._waiting.append(order)
            self._send()
        return order.future

    def close(self) -> None:
        """Kill whatever runs."""
        with self._lock:
            if self._closed:
                return
            self._closed = True
            for order in self._waiting:
                order.future.cancel()
            self._waiting.clear()
        self._pool.shutdown(wait=True, kill_workers=True)
        self._folder.cleanup()

    def _new_pool(self) -> ProcessPoolExecutor:
        return ProcessPoolExecutor(self._jobs, initializer=_settle, initargs=(os.getpid(), self._folder.name))

    def _send(self) -> None:
        """Give the pool as much as it has workers."""
        while self._waiting and len(self._flying) < self._jobs and not self._closed:
            order = self._waiting.popleft()
            if order.lives == LIVES and not order.future.set_running_or_notify_cancel():
                continue
            try:
                inner = self._given(order)
            except Exception as error:  # no more processes, no memory: whoever waits must hear of it
                order.future.set_exception(error)
            else:
                self._flying[inner] = order
                inner.add_done_callback(self._landed)

    def _given(self, order: _Order) -> Future[Run]:
        arguments = (order.task, order.parcel.digest, order.parcel.content, self._origin)
        try:
            given: Future[Run] = self._pool.submit(_from_file, *arguments)
        except BrokenProcessPool:
            self._pool = self._new_pool()
            given = self._pool.submit(_from_file, *arguments)
        return given

    def _landed(self, inner: Future[Run]) -> None:
        with self._lock:
            order = self._flying.pop(inner)
            error = inner.exception()
            if error is None:
                order.future.set_result(inner.result())
            elif self._closed:
                order.future.set_exception(CancelledError())
            elif not isinstance(error, BrokenProcessPool):
                order.future.set_exception(error)
            elif order.lives == 1:
                order.future.set_result(order.task.failed(f"its worker was killed {LIVES} times"))
            else:
                order.lives -= 1
                self._waiting.appendleft(order)
            self._send()


def _from_file(task: Task, name: str, path: Path, origin: Origin) -> Run:
    return guarded(task, name, path.read_bytes, origin)


def _settle(owner: int, folder: str) -> None:
    """Leave Ctrl-C to the process that owns the pool, and go when it is gone: loky's workers would stay for ever."""
    signal.signal(signal.SIGINT, signal.SIG_IGN)
    threading.Thread(target=_go_with, args=(owner, folder), daemon=True).start()


def _go_with(owner: int, folder: str) -> None:
    while os.getppid() == owner:
        time.sleep(LOOK_S)
    shutil.rmtree(folder, ignore_errors=True)
    os._exit(1)
