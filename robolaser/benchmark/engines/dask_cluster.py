"""Runs on a Dask cluster."""

import asyncio
import logging
import threading
import time
import warnings
from collections.abc import Callable, Mapping
from concurrent.futures import CancelledError, Future
from contextlib import suppress
from dataclasses import dataclass
from typing import Any, TypeVar, final

from robolaser.benchmark.engines.engine import Engine, Payload, digest
from robolaser.benchmark.single_run import Run
from robolaser.benchmark.task import Task
from robolaser.benchmark.worker_pool import WorkerPool
from robolaser.benchmark.worker_process import Session
from robolaser.errors import ClusterDiffers, ClusterLost, DaskMissing, SchedulerUnreachable

ANSWER_S = 3.0
"""Within which a scheduler, then all its workers, say their versions, then the scheduler takes us on."""
CLOSE_S = 3.0
"""After which nobody waits for workers to say that they have stopped."""
FRESH_S = 1.0
"""So long a count of workers is good."""
PACKAGES = ("distributed", "dask", "robolaser", "numpy", "numba", "pymoo", "scipy")
"""Of which everybody must have the same version, lest the same run comes out otherwise."""

T = TypeVar("T")
Versions = Mapping[str, str | None]
"""Of Python, without the last digit, and of `PACKAGES`; None where it is missing."""


@final
@dataclass(frozen=True)
class _Foreign:
    """A worker that has other versions."""

    who: str
    versions: Versions


@final
class DaskCluster(Engine):
    """Runs on the workers of a Dask cluster, one in each of their threads.

    Runs that are lost with a worker are begun anew elsewhere, by the scheduler.

    Raises:
        DaskMissing: `distributed` is not installed.
        SchedulerUnreachable: No scheduler answers at the address.
        ClusterDiffers: Scheduler or workers have other versions than we.
    """

    def __init__(self, address: str) -> None:
        try:
            from distributed import Client  # noqa: PLC0415 - an extra, and slow to import
        except ImportError:
            raise DaskMissing from None
        self.label = address
        self._session = Session.here()
        self._versions = _compared(address)
        logging.getLogger("distributed.client").setLevel(logging.CRITICAL)  # what it has to say, our errors say
        try:
            self._client = Client(address, timeout=ANSWER_S, set_as_default=False, name="robolaser")
        except (OSError, ValueError) as error:
            raise SchedulerUnreachable(address, str(error)) from error
        self._executor = self._client.get_executor(pure=False)
        self._counted, self._threads = -FRESH_S, 0
        self._closed = False

    @property
    def workers(self) -> int:
        """Threads of all workers; one where there are none yet."""
        return max(self._count(), 1)

    @property
    def empty(self) -> bool:
        """Whether there are no workers yet: runs wait for the first."""
        return self._count() == 0

    def share(self, payload: bytes) -> Payload:
        """Give it to the scheduler as a task: data that is only scattered is lost with the worker that has it."""
        name = digest(payload)
        with warnings.catch_warnings():
            warnings.filterwarnings("ignore", "Sending large graph", UserWarning)
            content = self._client.submit(_itself, payload, key=f"question-{name}-{self._session.name}")
        return Payload(name, content)

    def submit(self, task: Task, payload: Payload) -> Future[Run]:
        """Have a run made."""
        outer: Future[Run] = Future()
        outer.set_running_or_notify_cancel()
        if self._client.status != "running":  # what is said to a lost scheduler is not heard, and nobody answers
            outer.set_exception(ClusterLost(self.label))
            return outer
        inner = self._executor.submit(_on_worker, task, payload.digest, payload.content, self._session, self._versions)
        inner.add_done_callback(lambda inner: self._landed(task, inner, outer))
        return outer

    def close(self) -> None:
        """Have the workers kill whatever runs, and leave the cluster."""
        if self._closed:
            return
        self._closed = True
        self._executor.shutdown(wait=False)
        with suppress(Exception):  # nor may it fail because a worker does
            _aside(lambda: self._client.run(_close_pool, self._session, on_error="ignore")).result(CLOSE_S)
        self._client.close(timeout=CLOSE_S)

    def _landed(self, task: Task, inner: Future[Run | _Foreign], outer: Future[Run]) -> None:
        from distributed import KilledWorker  # noqa: PLC0415

        error = CancelledError() if inner.cancelled() else inner.exception()
        if error is None:
            made = inner.result()
            if isinstance(made, Run):
                outer.set_result(made)
            else:
                outer.set_exception(ClusterDiffers(self.label, self._versions, {made.who: made.versions}))
        elif self._closed:
            outer.set_exception(CancelledError())
        elif isinstance(error, KilledWorker):
            outer.set_result(task.failed(f"{error.allowed_failures + 1} workers died while they had it"))
        elif isinstance(error, CancelledError):
            outer.set_exception(ClusterLost(self.label))
        else:  # robolaser or the question is broken there
            outer.set_result(task.failed(f"its worker could not begin it ({type(error).__name__}: {error})"))

    def _count(self) -> int:
        if time.monotonic() - self._counted > FRESH_S:
            try:
                self._threads = sum(self._client.nthreads().values())
            except (OSError, ValueError) as error:
                raise ClusterLost(self.label) from error
            self._counted = time.monotonic()
        return self._threads


def _compared(address: str) -> Versions:
    """Our versions, which are the scheduler's and all workers' too.

    Raises:
        SchedulerUnreachable, ClusterDiffers: As `DaskCluster` does.
    """
    from distributed.versions import get_versions  # noqa: PLC0415

    try:
        others = _aside(lambda: asyncio.run(_asked(address))).result(2 * ANSWER_S)
    except TimeoutError:
        raise SchedulerUnreachable(address, "it is no scheduler, or not of our version: it does not answer") from None
    except (OSError, ValueError) as error:
        raise SchedulerUnreachable(address, str(error.__cause__ or error).split(">: ")[-1]) from error
    except Exception as error:  # whatever breaks at a stranger's answer
        why = f"it is no scheduler, or not of our version ({type(error).__name__}: {error})"
        raise SchedulerUnreachable(address, why) from error
    ours = _versions(get_versions(packages=PACKAGES))
    different = {who: theirs for who, theirs in others.items() if theirs != ours}
    if different:
        raise ClusterDiffers(address, ours, different)
    return ours


async def _asked(address: str) -> Mapping[str, Versions]:
    """Versions of the scheduler and all workers, by who."""
    from distributed import Security  # noqa: PLC0415
    from distributed.core import rpc  # noqa: PLC0415

    scheduler = rpc(address, timeout=0.8 * ANSWER_S, connection_args=Security().get_connection_args("client"))
    try:
        async with asyncio.timeout(ANSWER_S):
            said = {"the scheduler": await scheduler.versions(packages=PACKAGES)}
        async with asyncio.timeout(ANSWER_S):
            of_workers = await scheduler.broadcast(msg={"op": "versions", "packages": PACKAGES}, on_error="ignore")
    finally:
        await scheduler.close_rpc()
    said |= {f"worker {worker}": what for worker, what in of_workers.items() if what}
    return {who: _versions(what) for who, what in said.items()}


def _versions(said: Mapping[str, Any]) -> Versions:
    packages = said["packages"]
    python = ".".join(packages["python"].split(".")[:2])
    return {"python": python} | {package: packages.get(package) for package in PACKAGES}


def _on_worker(task: Task, name: str, payload: bytes, session: Session, wanted: Versions) -> Run | _Foreign:
    """Make a run, unless this worker, which may have come later, has other versions."""
    from distributed import get_worker  # noqa: PLC0415
    from distributed.versions import get_versions  # noqa: PLC0415

    worker, ours = get_worker(), _versions(get_versions(packages=PACKAGES))
    if ours != wanted:
        return _Foreign(f"worker {worker.address}", ours)
    return _pool(worker, session).run(task, name, lambda: payload)


def _pool(worker: Any, session: Session) -> WorkerPool:
    """The worker processes of a session on a Dask worker, which keeps them between runs."""
    pool: WorkerPool = vars(worker).setdefault(f"robolaser-{session.name}", WorkerPool(session))
    return pool


def _close_pool(session: Session, dask_worker: Any) -> None:
    _pool(dask_worker, session).close()


def _itself(payload: bytes) -> bytes:
    return payload


def _aside(do: Callable[[], T]) -> Future[T]:
    """Do something for which nobody may want to wait to the end."""
    outcome: Future[T] = Future()

    def work() -> None:
        try:
            outcome.set_result(do())
        except BaseException as error:
            outcome.set_exception(error)

    threading.Thread(target=work, daemon=True).start()
    return outcome
