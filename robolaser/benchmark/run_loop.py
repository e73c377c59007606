"""The loop of a benchmark: runs are handed to an engine and collected in the order in which they are done."""

import math
import time
from collections.abc import Callable, Iterator, Mapping
from concurrent.futures import Future
from dataclasses import dataclass
from itertools import islice
from queue import Empty, SimpleQueue
from types import MappingProxyType
from typing import final

import cloudpickle

from robolaser.arrays import Progress
from robolaser.benchmark import racing
from robolaser.benchmark.engines import Engine, ThisMachine
from robolaser.benchmark.plan import RunPlan
from robolaser.benchmark.result import BenchmarkResult
from robolaser.benchmark.setting_space import SettingSpace
from robolaser.benchmark.single_run import BenchmarkRun, Key
from robolaser.benchmark.table import RunTable
from robolaser.benchmark.task import Task

AHEAD = 2
"""Runs handed out for each worker, so that none waits for its next."""
REPORT_S = 0.5
"""Time between two reports of progress."""
MOST_SHOWN = 4
"""Runs under way that a line has room for."""


@final
@dataclass(frozen=True)
class RunProgress:
    """How far a benchmark has come."""

    done: int  # runs that were made
    wanted: int  # runs that were planned
    running: tuple[Task, ...]  # runs under way: those handed out longest ago; none while there are no workers
    left_s: float | None  # estimated time that the others will take [s]; None before any run is done

    @property
    def share(self) -> float:
        """The share that is done, 0 to 1."""
        return self.done / max(1, self.wanted)

    @property
    def words(self) -> str:
        """How far it has come, and what runs now."""
        running = "; ".join(f"{run.algorithm} on {run.problem}, seed {run.seed}" for run in self.running[:MOST_SHOWN])
        left = "" if self.left_s is None else f"{_duration(self.left_s)} left, "
        return f"{self.done}/{self.wanted} runs, {left}{running or 'waiting for the first worker'}"


def _duration(seconds: float) -> str:
    """A time in hours and minutes, or minutes and seconds."""
    minutes, rest = divmod(round(seconds), 60)
    return f"{minutes // 60} h {minutes % 60} min" if minutes >= 60 else f"{minutes}:{rest:02d}"


def run_all(
    plan: RunPlan,
    engine: Engine,
    *,
    made: Mapping[Key, float] = MappingProxyType({}),
    on_progress: Callable[[RunProgress], None] = lambda progress: None,
) -> Iterator[BenchmarkRun]:
    """Make all runs of a plan but those made already, which took so long, and yield each as soon as it is done."""
    payloads = {spec.name: engine.share(cloudpickle.dumps(spec)) for spec in plan.specs}
    planned = {task.key for task in plan.tasks}
    done = {key: seconds for key, seconds in made.items() if key in planned}
    waiting = iter([task for task in plan.tasks if task.key not in done])
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
            done[run.key] = run.seconds
            yield run
        if time.monotonic() - reported > REPORT_S:
            running = () if engine.empty else tuple(islice(pending.values(), engine.workers))
            on_progress(RunProgress(len(done), len(plan.tasks), running, _left_s(plan, done, engine.workers)))
            reported = time.monotonic()


def compare(
    plan: RunPlan,
    engine: Engine | None = None,
    *,
    race: bool = False,
    space: SettingSpace | None = None,
    progress: Progress | None = None,
) -> BenchmarkResult:
    """Make all runs of a plan, and write nothing to disk.

    Args:
        plan: Which solvers run on which problems, see `RunPlan.of`.
        engine: Where the runs are made; on all cores of this machine by default.
        race: Drop, seed by seed, who is significantly worse than the best, see `racing.race`.
        space: Where a race takes further settings from.
        progress: Called twice a second with how far it has come, in words, and the share that is done.

    Examples:
        >>> plan = robolaser.RunPlan.of(["pymoo:sphere-2"], ["de"], seeds=1, budget=100)
        >>> robolaser.compare(plan).to_frame()["state"].tolist()
        ['done']
    """
    tell = progress or (lambda what, share: None)
    with engine or ThisMachine() as used, RunTable() as table:
        for stage in racing.race(plan, table, space) if race else (plan,):
            fill(table, stage, used, lambda at: tell(at.words, at.share))
        return table.result(stage)


def fill(
    table: RunTable,
    plan: RunPlan,
    engine: Engine,
    on_progress: Callable[[RunProgress], None] = lambda progress: None,
) -> None:
    """Make all runs of a plan that a table lacks; progress is told twice a second.

    Raises:
        BenchmarkError: The runs in the table were made under other conditions, or the engine was lost.
        OutputError: The table cannot be written.
    """
    table.begin(plan, engine=engine.label, workers=engine.workers)
    began = time.monotonic()
    for run in run_all(plan, engine, made={**table.made(), **table.failed}, on_progress=on_progress):
        table.add(run, after_s=time.monotonic() - began)


def _left_s(plan: RunPlan, done: Mapping[Key, float], workers: int) -> float | None:
    """Time that the remaining runs will take, estimated from those of the same problem and solver."""
    if not done:
        return None
    taken: dict[tuple[str, str], list[float]] = {}
    for (problem, algorithm, _), seconds in done.items():
        taken.setdefault((problem, algorithm), []).append(seconds)
    means = {pair: sum(times) / len(times) for pair, times in taken.items()}
    overall = sum(means.values()) / len(means)
    left = (means.get((task.problem, task.algorithm), overall) for task in plan.tasks if task.key not in done)
    return sum(left) / workers
