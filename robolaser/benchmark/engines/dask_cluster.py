"""Runs on a Dask cluster."""

import asyncio
import hashlib
import logging
import threading
import time
import uuid
import warnings
from collections.abc import Callable, Mapping, Sequence
from concurrent.futures import CancelledError, Future
from contextlib import suppress
from typing import Any, TypeVar, final

from robolaser.benchmark.engines.engine import Engine, EngineLost, Job
from robolaser.benchmark.engines.this_machine import WorkerPool
from robolaser.benchmark.engines.worker_process import import_paths
from robolaser.errors import BenchmarkError, DependencyMissing

ANSWER_S = 3.0
"""Time for a scheduler, then for all its workers, to state their versions, and for the scheduler to accept us."""
CLOSE_S = 3.0
"""Time for workers to confirm that they have stopped."""
FRESH_S = 1.0
"""Time for which a count of workers is valid."""
DASK = ("distributed", "dask")
"""Packages whose versions must be the same everywhere for the cluster to work at all."""
PACKAGES = ("robolaser", "numpy", "numba", "pymoo", "scipy")
"""Packages whose other versions could give another result, unless the caller knows better."""

T = TypeVar("T")
Versions = Mapping[str, str | None]
"""Versions of Python, without the last number, and of packages; None if one is missing."""


@final
class DaskCluster(Engine):
    """Runs on the workers of a Dask cluster, one in each of their threads.

    The scheduler restarts runs that are lost with a worker elsewhere.

    Args:
        address: Of the scheduler.
        packages: Those whose versions must be the same everywhere, besides Dask's.

    Raises:
        DependencyMissing: `distributed` is not installed.
        BenchmarkError: No scheduler answers at the address, or the cluster has other versions than we.
    """

    def __init__(self, address: str, packages: Sequence[str] = PACKAGES) -> None:
        try:
            from distributed import Client  # noqa: PLC0415 - an extra, and slow to import
        except ImportError:
            raise DependencyMissing("Dask's `distributed` is not installed: pip install 'robolaser[dask]'.") from None
        self.label = address
        self._name, self._paths = uuid.uuid4().hex, import_paths()  # of the pools of this program
        self._versions = _compared(address, (*DASK, *packages))
        logging.getLogger("distributed.client").setLevel(logging.CRITICAL)  # our errors say it
        try:
            self._client = Client(address, timeout=ANSWER_S, set_as_default=False, name="robolaser")
        except (OSError, ValueError) as error:
            raise _unreachable(address, str(error)) from error
        self._executor = self._client.get_executor(pure=False)
        self._counted, self._threads = -FRESH_S, 0
        self._closed = False

    @property
    def workers(self) -> int:
        """Threads of all Dask workers; one while there are none yet."""
        return max(self._count(), 1)

    @property
    def empty(self) -> bool:
        """Whether there are no Dask workers yet: runs wait for the first."""
        return self._count() == 0

    def share(self, payload: bytes) -> tuple[str, Any]:
        """Give it to the scheduler as a task: scattered data would be lost with the worker that has it."""
        digest = hashlib.sha256(payload).hexdigest()
        with warnings.catch_warnings():
            warnings.filterwarnings("ignore", "Sending large graph", UserWarning)
            return digest, self._client.submit(bytes, payload, key=f"problem-{digest}-{self._name}")

    def submit(self, job: Job, shared: tuple[str, Any]) -> Future[Any]:
        """Have a job done."""
        outer: Future[Any] = Future()
        outer.set_running_or_notify_cancel()
        if self._client.status != "running":  # a lost scheduler would never answer
            outer.set_exception(_lost(self.label))
            return outer
        inner = self._executor.submit(_on_worker, job, *shared, self._name, self._paths, self.label, self._versions)
        inner.add_done_callback(lambda inner: self._completed(job, inner, outer))
        return outer

    def close(self) -> None:
        """Have the workers kill whatever runs, and leave the cluster."""
        if self._closed:
            return
        self._closed = True
        self._executor.shutdown(wait=False)
        with suppress(Exception):  # nor may it fail because a worker does
            _in_thread(lambda: self._client.run(_close_pool, self._name, on_error="ignore")).result(CLOSE_S)
        with suppress(RuntimeError):  # distributed may reschedule a timeout that a lost scheduler has let expire
            self._client.close(timeout=CLOSE_S)

    def _completed(self, job: Job, inner: Future[Any], outer: Future[Any]) -> None:
        from distributed import KilledWorker  # noqa: PLC0415

        error = CancelledError() if inner.cancelled() else inner.exception()
        if error is None:
            outer.set_result(inner.result())
        elif self._closed:
            outer.set_exception(CancelledError())
        elif isinstance(error, KilledWorker):
            outer.set_result(job.failed(f"{error.allowed_failures + 1} workers died while they had it"))
        elif isinstance(error, CancelledError):
            outer.set_exception(_lost(self.label))
        elif isinstance(error, BenchmarkError):
            outer.set_exception(error)
        else:  # robolaser or the problem is broken there
            outer.set_result(job.failed(f"its worker could not begin it ({type(error).__name__}: {error})"))

    def _count(self) -> int:
        if time.monotonic() - self._counted > FRESH_S:
            try:
                self._threads = sum(self._client.nthreads().values())
            except (OSError, ValueError) as error:
                raise _lost(self.label) from error
            self._counted = time.monotonic()
        return self._threads


def _compared(address: str, packages: Sequence[str]) -> Versions:
    """Our versions, which are the scheduler's and all workers' too; else a BenchmarkError."""
    try:
        others = _in_thread(lambda: asyncio.run(_fetch_versions(address, packages))).result(2 * ANSWER_S)
    except TimeoutError:
        raise _unreachable(
            address, "it is not a Dask scheduler, or one of another version: it does not answer"
        ) from None
    except (OSError, ValueError) as error:
        raise _unreachable(address, str(error.__cause__ or error).split(">: ")[-1]) from error
    except Exception as error:  # whatever the answer of another program breaks
        why = f"it is not a Dask scheduler, or one of another version ({type(error).__name__}: {error})"
        raise _unreachable(address, why) from error
    return _equal(address, _versions(packages), others)


async def _fetch_versions(address: str, packages: Sequence[str]) -> Mapping[str, Versions]:
    """Versions of the scheduler and of all workers: a Client waits far longer for what is no scheduler."""
    from distributed import Security  # noqa: PLC0415
    from distributed.core import rpc  # noqa: PLC0415

    scheduler = rpc(address, timeout=0.8 * ANSWER_S, connection_args=Security().get_connection_args("client"))
    try:
        async with asyncio.timeout(ANSWER_S):
            found = {"the scheduler": await scheduler.versions(packages=packages)}
        async with asyncio.timeout(ANSWER_S):
            of_workers = await scheduler.broadcast(msg={"op": "versions", "packages": packages}, on_error="ignore")
    finally:
        await scheduler.close_rpc()
    found |= {f"worker {worker}": what for worker, what in of_workers.items() if what}
    return {who: _versions(packages, what) for who, what in found.items()}


def _versions(packages: Sequence[str], info: Mapping[str, Any] | None = None) -> Versions:
    """Versions as Dask states them, by default of this process."""
    from distributed.versions import get_versions  # noqa: PLC0415

    found = (get_versions(packages=packages) if info is None else info)["packages"]
    python = ".".join(found["python"].split(".")[:2])
    return {package: found.get(package) for package in packages} | {"python": python}


def _equal(address: str, ours: Versions, others: Mapping[str, Versions]) -> Versions:
    """Our versions, if all others are the same; else a BenchmarkError names each that differs, and on whom."""
    owners: dict[str, list[str]] = {}
    for who, theirs in others.items():
        for package, version in theirs.items():
            if version != ours[package]:
                difference = f"{package} {ours[package] or 'missing'} here, {version or 'missing'} on"
                owners.setdefault(difference, []).append(who)
    if not owners:
        return ours
    found = [f"{what} {who[0]}" + (f" and {len(who) - 1} more" if who[1:] else "") for what, who in owners.items()]
    raise BenchmarkError(
        f"The Dask cluster at {address} has other versions than this machine, so its results would differ:"
        f" {'; '.join(found)}. Install the same versions everywhere."
    )


def _on_worker(
    job: Job, digest: str, payload: bytes, name: str, paths: tuple[str, ...], address: str, wanted: Versions
) -> Any:
    """Do a job, unless this Dask worker, which may have joined later, has other versions."""
    from distributed import get_worker  # noqa: PLC0415

    worker = get_worker()
    packages = [package for package in wanted if package != "python"]
    _equal(address, wanted, {f"worker {worker.address}": _versions(packages)})
    pool: WorkerPool = vars(worker).setdefault(f"robolaser-{name}", WorkerPool(paths))  # kept between runs
    return pool.do(job, digest, lambda: payload)


def _close_pool(name: str, dask_worker: Any) -> None:
    vars(dask_worker).setdefault(f"robolaser-{name}", WorkerPool()).close()


def _in_thread(do: Callable[[], T]) -> Future[T]:
    """Call a function in a thread that need not be waited for."""
    outcome: Future[T] = Future()

    def work() -> None:
        try:
            outcome.set_result(do())
        except BaseException as error:
            outcome.set_exception(error)

    threading.Thread(target=work, daemon=True).start()
    return outcome


def _unreachable(address: str, reason: str) -> BenchmarkError:
    return BenchmarkError(
        f"No Dask scheduler could be reached at '{address}': {reason.rstrip('.')}. Expected the address that"
        " `dask scheduler` prints, such as tcp://host:8786, from a machine that may reach it."
    )


def _lost(address: str) -> EngineLost:
    return EngineLost(f"The Dask scheduler at {address} no longer answers.")
