"""A contest is held: runs go out to an engine, and come back in whatever order they are done."""

import math
import pickle
import time
from collections.abc import Callable, Collection, Iterator, Mapping
from concurrent.futures import Future
from dataclasses import dataclass
from itertools import islice
from queue import Empty, SimpleQueue
from typing import final

from robolaser.benchmark.engines import Engine, Task, ThisMachine
from robolaser.benchmark.plan import Contest, Key, key
from robolaser.benchmark.result import Comparison, Effort
from robolaser.benchmark.single_run import Run

AHEAD = 2
"""Runs handed out for each worker, so that none waits for the next."""
LOOK_S = 0.5
"""How often whoever watches is told."""


@final
@dataclass(frozen=True)
class Moment:
    """How far a contest has come.

    Attributes:
        done: Runs that were made.
        wanted: Runs that were asked for.
        running: What runs now: those handed out longest ago; nothing while there are no workers.
        left_s: Time that the others will take [s]; None while nobody can say.
    """

    done: int
    wanted: int
    running: tuple[Task, ...]
    left_s: float | None


def held(
    contest: Contest,
    engine: Engine,
    *,
    made: Collection[Run] = (),
    tell: Callable[[Moment], None] = lambda moment: None,
) -> Iterator[Run]:
    """Hold a contest, and give each run as it comes.

    Args:
        contest: What is asked of whom.
        engine: Where.
        made: Runs that need not be made again.
        tell: Is told how far it has come, twice a second.
    """
    payloads = {source.name: engine.share(pickle.dumps(source)) for source in contest.sources}
    done = {key(run): run for run in made}
    coming = iter([task for task in contest.tasks if key(task) not in done])
    flying: dict[Future[Run], Task] = {}
    landed: SimpleQueue[Future[Run]] = SimpleQueue()
    told = -math.inf
    while True:
        while len(flying) < AHEAD * engine.workers and (task := next(coming, None)) is not None:
            future = engine.submit(task, payloads[task.problem])
            flying[future] = task
            future.add_done_callback(landed.put)
        if not flying:
            return
        try:
            future = landed.get(timeout=LOOK_S)
        except Empty:
            pass
        else:
            del flying[future]
            run = future.result()
            done[key(run)] = run
            yield run
        if time.monotonic() - told > LOOK_S:
            running = () if engine.empty else tuple(islice(flying.values(), engine.workers))
            tell(Moment(len(done), len(contest.tasks), running, _left_s(contest, done, engine.workers)))
            told = time.monotonic()


def compare(contest: Contest, engine: Engine | None = None) -> Comparison:
    """Hold a contest, and keep nothing on disk.

    Args:
        contest: What is asked of whom, see `Contest.of`.
        engine: Where; all cores of this machine by default.
    """
    began = time.monotonic()
    with engine or ThisMachine() as chosen:
        workers = chosen.workers
        runs = tuple(held(contest, chosen, tell=lambda moment: None))
        lasted_s = time.monotonic() - began
        busy_s = sum(run.seconds for run in runs)
        return contest.so_far(runs, Effort(chosen.label, workers, lasted_s, lasted_s * workers, busy_s))


def _left_s(contest: Contest, done: Mapping[Key, Run], workers: int) -> float | None:
    """Time that the runs left will take, judged by those that were made."""
    if not done:
        return None
    taken: dict[tuple[str, str], list[float]] = {}
    for run in done.values():
        taken.setdefault((run.problem, run.algorithm), []).append(run.seconds)
    means = {pair: sum(times) / len(times) for pair, times in taken.items()}
    usual = sum(means.values()) / len(means)
    left = (means.get((task.problem, task.algorithm), usual) for task in contest.tasks if key(task) not in done)
    return sum(left) / workers
