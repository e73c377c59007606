"""The comparison: runs in processes or on a cluster, written as they end."""

import math
import tempfile
import threading
import time
from collections.abc import Callable, Iterator, Mapping, Sequence
from concurrent.futures import FIRST_COMPLETED, CancelledError, Future, wait
from contextlib import contextmanager
from dataclasses import replace
from datetime import timedelta
from itertools import islice
from pathlib import Path
from statistics import fmean
from typing import Any, Literal

from robolaser.algorithms.user_code import Given
from robolaser.arrays import Progress
from robolaser.benchmark import BUDGET, SEEDS, TIME_LIMIT_S
from robolaser.benchmark.executors import Engine, WorkerLost, engine_of
from robolaser.benchmark.journal import NAME, Journal
from robolaser.benchmark.plan import BenchmarkPlan, Terms
from robolaser.benchmark.result import BenchmarkResult
from robolaser.benchmark.run import BenchmarkRun, RunKey, Task, done
from robolaser.benchmark.solvers import DEFAULT
from robolaser.data.result_folder import results_in
from robolaser.errors import Interrupted, OutputError

FILES = ("comparison.json", "runs.csv", "report.html")
AHEAD = 4  # runs queued for each worker, so that none is idle
GRACE_S = 10.0  # time after its limit until a blocked run is killed
REPORT_S = 0.5  # time between two reports of progress


def compare(
    problems: Given,
    algorithms: Given = DEFAULT,
    *,
    seeds: int = SEEDS,
    first_seed: int = 1,
    budget: int | str = BUDGET,
    target: float | None = None,
    time_limit_s: float = TIME_LIMIT_S,
    on_error: Literal["fail", "inf"] = "fail",
    jobs: int | None = None,
    scheduler: str | None = None,
    output: str | Path | None = None,
    resume: bool = False,
    force: bool = False,
    progress: Progress | None = None,
    write: Callable[[BenchmarkResult, Path], None] = lambda result, folder: None,
) -> BenchmarkResult:
    """Run algorithms side by side, and report which is better, by how much, and with which certainty.

    Args:
        problems: Names, as in `robolaser compare`, or pymoo problems (class, instance or function); a mapping
            names them.
        algorithms: Names, or pymoo algorithms, or functions `search(evaluator, seed)`; a mapping gives them
            names.
        seeds: Number of runs of each algorithm on each problem.
        first_seed: The first of their seeds, at least 1.
        budget: Evaluations of a run: a number, or "1000d" for a thousand times the number of variables.
        target: How far above the lowest known cost counts as reached: absolute, for calibrations a share of J, for
            several objectives IGD+. Default: 0.01.
        time_limit_s: Wall time of a run [s]; its best result by then counts.
        on_error: "fail": a candidate whose evaluation raises ends its run; "inf": it costs infinity.
        jobs: Runs at a time; one on each core by default.
        scheduler: Address of a Dask cluster that makes the runs instead, tcp://HOST:PORT.
        output: Folder for the result; runs are written to it as they end. None: nothing is written.
        resume: Continue with the runs in `output`.
        force: Replace the result in `output`.
        progress: Called twice a second with the progress in words and the finished share.
        write: Writes the result's files to `output`.

    Raises:
        RobolaserError: As `robolaser.compare`.
    """
    terms = Terms(tuple(range(first_seed, first_seed + seeds)), budget, target, time_limit_s, on_error)
    folder = None if output is None else Path(output)
    if folder is not None:
        refuse_to_mix(folder, resume=resume, force=force)
    plan = BenchmarkPlan.of(problems, algorithms, terms)
    given = problems.values() if isinstance(problems, Mapping) else problems
    paths = [Path(str(one).removeprefix("reduced:")) for one in given if isinstance(one, str | Path)]
    inputs = [path for path in paths if path.is_dir()]
    with _journal(folder, inputs, resume=resume, force=force) as journal:
        planned, why = plan.to_dict(), ""
        try:
            with (
                engine_of(jobs, scheduler, time_limit_s=min(time_limit_s + GRACE_S, threading.TIMEOUT_MAX)) as engine,
                tempfile.TemporaryDirectory(prefix="robolaser-runs-") as spills,
            ):
                planned |= {"engine": engine.label, "workers": engine.workers}
                journal.begin(planned)
                began = time.monotonic()
                for run in _runs(plan, engine, journal.done(), Path(spills), progress):
                    journal.add(run, after_s=time.monotonic() - began)
        except (KeyboardInterrupt, CancelledError) as stopped:
            why = "Stopped" if isinstance(stopped, KeyboardInterrupt) else "The cluster is lost"
        result = journal.result(planned)
    written = folder if "engine" in planned else None  # nothing, where it was stopped before it began
    if written is not None:
        write(result, written)
    if why:
        where = f" They are in {written}: continue with --resume." if written else ""
        raise Interrupted(f"{why}, after {len(result.runs)} of {len(plan.tasks)} runs.{where}") from None
    return result


def _runs(
    plan: BenchmarkPlan, engine: Engine, made: Mapping[RunKey, float], spills: Path, progress: Progress | None
) -> Iterator[BenchmarkRun]:
    """Make the missing runs, and yield each as soon as it is done; `made` has the times of the others [s]."""
    lacking = [task for task in plan.tasks if task.key not in made]
    seconds = [made[task.key] for task in plan.tasks if task.key in made]
    waiting, pending = enumerate(lacking), dict[Future[BenchmarkRun], Task]()
    local, reported = engine.label == "this machine", -math.inf
    while True:
        for number, task in islice(waiting, AHEAD * engine.workers - len(pending)):
            kept = local and not task.limits.noisy  # the lowest noisy sample has no meaning
            watched = replace(task, spill=str(spills / str(number))) if kept else task
            pending[engine.executor.submit(done, watched)] = watched
        if not pending:
            return
        for future in wait(pending, timeout=REPORT_S, return_when=FIRST_COMPLETED).done:
            task = pending.pop(future)
            try:
                run = future.result()
            except WorkerLost as error:
                run = task.lost(str(error))
            except CancelledError:
                raise
            except Exception as error:  # workers of the cluster were lost repeatedly
                run = task.lost(f"{type(error).__name__}: {error}")
            if task.spill:
                Path(task.spill).unlink(missing_ok=True)
            seconds.append(run.seconds)
            yield run
        if progress is not None and time.monotonic() - reported > REPORT_S:
            progress(_words(seconds, len(plan.tasks), engine.workers), len(seconds) / len(plan.tasks))
            reported = time.monotonic()


def _words(seconds: Sequence[float], wanted: int, workers: int) -> str:
    """Number of finished runs, and the estimated time of the others."""
    if not seconds:
        return f"0/{wanted} runs"
    left_s = fmean(seconds) * (wanted - len(seconds)) / workers
    return f"{len(seconds)}/{wanted} runs, {timedelta(seconds=round(left_s))} left"


@contextmanager
def _journal(folder: Path | None, inputs: Sequence[Path], *, resume: bool, force: bool) -> Iterator[Journal]:
    """The journal of a folder, which is locked for this comparison."""
    if folder is None:
        yield Journal()
        return
    kept: dict[str, Any] = {"files": FILES, "state": [NAME], "inputs": inputs, "force": force or resume}
    with results_in(folder, command="compare", **kept):
        yield Journal(folder / NAME, resume=resume)


def refuse_to_mix(folder: Path, *, resume: bool, force: bool) -> None:
    """Raise if runs would be overwritten."""
    if resume or force or not (folder / NAME).is_file():
        return
    runs = len(Journal.read([folder / NAME]))
    if runs:
        raise OutputError(
            f"{folder} holds {runs} runs of a comparison. Continue or extend it with --resume; start over with --force."
        )
