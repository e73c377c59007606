"""The loop of a benchmark: runs are handed to an engine and collected in the order in which they are done."""

import math
import time
from collections import defaultdict
from collections.abc import Iterator, Mapping, Sequence
from concurrent.futures import Future
from itertools import islice
from queue import Empty, SimpleQueue
from statistics import fmean
from types import MappingProxyType

import cloudpickle

from robolaser.arrays import Progress
from robolaser.benchmark import racing
from robolaser.benchmark.engines import Engine, ThisMachine
from robolaser.benchmark.plan import RunPlan
from robolaser.benchmark.result import BenchmarkResult
from robolaser.benchmark.setting_space import SettingSpace
from robolaser.benchmark.single_run import BenchmarkRun, Key, Task
from robolaser.benchmark.table import RunTable

AHEAD = 2
"""Runs handed out for each worker, so that none waits for its next."""
REPORT_S = 0.5
"""Time between two reports of progress."""
MOST_SHOWN = 4
"""Runs under way that a line has room for."""


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
    with engine or ThisMachine() as used, RunTable() as table:
        for stage in racing.race(plan, table, space) if race else (plan,):
            fill(table, stage, used, progress)
        return table.result(stage)


def fill(table: RunTable, plan: RunPlan, engine: Engine, progress: Progress | None = None) -> None:
    """Make all runs of a plan that a table lacks; progress is told twice a second.

    Raises:
        BenchmarkError: The runs in the table were made under other conditions, or the engine was lost.
        OutputError: The table cannot be written.
    """
    table.begin(plan, engine=engine.label, workers=engine.workers)
    began = time.monotonic()
    for run in run_all(plan, engine, made={**table.made(), **table.failed}, progress=progress):
        table.add(run, after_s=time.monotonic() - began)


def run_all(
    plan: RunPlan,
    engine: Engine,
    *,
    made: Mapping[Key, float] = MappingProxyType({}),
    progress: Progress | None = None,
) -> Iterator[BenchmarkRun]:
    """Make all runs of a plan but those made already, which took so long, and yield each as soon as it is done."""
    shared = {spec.name: engine.share(cloudpickle.dumps(spec)) for spec in plan.specs}
    planned = {task.key for task in plan.tasks}
    done = {key: seconds for key, seconds in made.items() if key in planned}
    waiting = iter([task for task in plan.tasks if task.key not in done])
    pending: dict[Future[BenchmarkRun], Task] = {}
    completed: SimpleQueue[Future[BenchmarkRun]] = SimpleQueue()
    reported = -math.inf
    while True:
        while len(pending) < AHEAD * engine.workers and (task := next(waiting, None)) is not None:
            future = engine.submit(task, shared[task.problem])
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
        if progress is not None and time.monotonic() - reported > REPORT_S:
            running = [] if engine.empty else list(islice(pending.values(), engine.workers))
            progress(_words(plan, done, running, engine.workers), len(done) / len(plan.tasks))
            reported = time.monotonic()


def _words(plan: RunPlan, done: Mapping[Key, float], running: Sequence[Task], workers: int) -> str:
    """How far it has come, how long the others will take by those of the same problem and solver, and what runs now."""
    taken = defaultdict(list)
    for (problem, algorithm, _), seconds in done.items():
        taken[problem, algorithm].append(seconds)
    left = ""
    if taken:
        means = {pair: fmean(times) for pair, times in taken.items()}
        overall = fmean(means.values())
        lacking = [task for task in plan.tasks if task.key not in done]
        left_s = sum(means.get((task.problem, task.algorithm), overall) for task in lacking) / workers
        minutes, seconds = divmod(round(left_s), 60)
        left = f"{minutes // 60} h {minutes % 60} min left, " if minutes >= 60 else f"{minutes}:{seconds:02d} left, "
    now = "; ".join(f"{task.algorithm} on {task.problem}, seed {task.seed}" for task in running[:MOST_SHOWN])
    return f"{len(done)}/{len(plan.tasks)} runs, {left}{now or 'waiting for the first worker'}"
