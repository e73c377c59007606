"""The loop of a benchmark: runs are handed to an engine and collected in the order in which they are done."""

import math
import time
from collections.abc import Callable, Collection, Iterator, Mapping
from concurrent.futures import Future
from dataclasses import dataclass
from itertools import islice
from queue import Empty, SimpleQueue
from typing import final

import cloudpickle

from robolaser.benchmark.engines import Engine, Task, ThisMachine
from robolaser.benchmark.plan import Key, RunPlan, key
from robolaser.benchmark.result import BenchmarkResult, Effort
from robolaser.benchmark.single_run import BenchmarkRun

AHEAD = 2
"""Runs handed out for each worker, so that none waits for its next."""
REPORT_S = 0.5
"""Time between two reports of progress."""


@final
@dataclass(frozen=True)
class RunProgress:
    """How far a benchmark has come.

    Attributes:
        done: Runs that were made.
        wanted: Runs that were planned.
        running: Runs under way: those handed out longest ago; none while there are no workers.
        left_s: Estimated time that the others will take [s]; None before any run is done.
    """

    done: int
    wanted: int
    running: tuple[Task, ...]
    left_s: float | None


def run_all(
    plan: RunPlan,
    engine: Engine,
    *,
    made: Collection[BenchmarkRun] = (),
    on_progress: Callable[[RunProgress], None] = lambda progress: None,
) -> Iterator[BenchmarkRun]:
    """Make all runs of a plan, and yield each as soon as it is done.

    Args:
        plan: Which runs.
        engine: Where they are made.
        made: Runs that need not be made again.
        on_progress: Called twice a second.
    """
    payloads = {spec.name: engine.share(cloudpickle.dumps(spec)) for spec in plan.specs}
    done = {key(run): run for run in made}
    waiting = iter([task for task in plan.tasks if key(task) not in done])
    pending: dict[Future[BenchmarkRun], Task] = {}
    completed: SimpleQueue[Future[BenchmarkRun]] = SimpleQueue()
    reported = -math.inf
    while True:
        while len(pending) < AHEAD * engine.workers and (task := next(waiting, None)) is not None:
            future = engine.submit(task, payloads[task.problem])
            pending[future] = task
            future.add_done_callback(completed.put)
        if not pending:
            return
        try:
            future = completed.get(timeout=REPORT_S)
        except Empty:
            pass
        else:
            del pending[future]
            run = future.result()
            done[key(run)] = run
            yield run
        if time.monotonic() - reported > REPORT_S:
            running = () if engine.empty else tuple(islice(pending.values(), engine.workers))
            on_progress(RunProgress(len(done), len(plan.tasks), running, _left_s(plan, done, engine.workers)))
            reported = time.monotonic()


def compare(plan: RunPlan, engine: Engine | None = None) -> BenchmarkResult:
    """Make all runs of a plan, and write nothing to disk.

    Args:
        plan: Which solvers run on which problems, see `RunPlan.of`.
        engine: Where the runs are made; on all cores of this machine by default.
    """
    began = time.monotonic()
    with engine or ThisMachine() as used:
        workers = used.workers
        runs = tuple(run_all(plan, used))
        lasted_s = time.monotonic() - began
        busy_s = sum(run.seconds for run in runs)
        return plan.result(runs, Effort(used.label, workers, lasted_s, lasted_s * workers, busy_s))


def _left_s(plan: RunPlan, done: Mapping[Key, BenchmarkRun], workers: int) -> float | None:
    """Time that the remaining runs will take, estimated from those of the same problem and solver."""
    if not done:
        return None
    taken: dict[tuple[str, str], list[float]] = {}
    for run in done.values():
        taken.setdefault((run.problem, run.algorithm), []).append(run.seconds)
    means = {pair: sum(times) / len(times) for pair, times in taken.items()}
    overall = sum(means.values()) / len(means)
    left = (means.get((task.problem, task.algorithm), overall) for task in plan.tasks if key(task) not in done)
    return sum(left) / workers
