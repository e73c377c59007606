"""robolaser compare: algorithms side by side."""

import time
from collections.abc import Callable, Iterable
from contextlib import suppress
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

from cyclopts import Parameter

from robolaser.benchmark.defaults import BUDGET, MEMORY_LIMIT_B, SEEDS, TIME_LIMIT_S
from robolaser.commands.options import RESULT, Count, Force, Positive, Resume, Typed
from robolaser.commands.signals import ended_as_by_hand
from robolaser.commands.terminal import TERMINAL, Terminal
from robolaser.errors import Interrupted, OutputError, UsageError

if TYPE_CHECKING:
    from robolaser.benchmark.engines import Engine
    from robolaser.benchmark.plan import RunPlan
    from robolaser.benchmark.record import RunRecord
    from robolaser.benchmark.run_loop import RunProgress

RESULT_FILE, RUNS, RECORD, PAGE, EXPORT = "comparison.json", "runs.csv", "runs.jsonl", "report.html", "iohprofiler"
GB = 1e9
MOST_SHOWN = 4
"""Runs under way that a line has room for."""


def compare(
    *datasets: str,
    output: Annotated[Path, Parameter(metavar="DIR", group=RESULT)],
    algorithms: Annotated[str | None, Parameter(metavar="A,B")] = None,
    seeds: Count = SEEDS,
    budget: Annotated[Count, Parameter(metavar="EVALS")] = BUDGET,
    time_limit: Annotated[Positive, Parameter(metavar="S")] = TIME_LIMIT_S,
    memory_limit: Annotated[Positive, Parameter(metavar="GB")] = MEMORY_LIMIT_B / GB,
    jobs: Count | None = None,
    scheduler: Annotated[str | None, Parameter(metavar="ADDRESS")] = None,
    seed: Count = 1,
    iohprofiler: Annotated[bool, Parameter(group=RESULT)] = False,
    resume: Resume = False,
    force: Force = False,
    terminal: Terminal = TERMINAL,
    typed: Typed = "",
) -> None:
    """Run algorithms side by side and say which is better, by how much, and how certain that is.

    For example:

        robolaser compare paper --algorithms rcga,de --output comparison
        robolaser compare measured pymoo:rastrigin-14 --seeds 30 --output comparison

    Args:
        datasets: Folders of data sets, `paper`, reduced:DATASET (its closed-form reduction), pymoo:NAME[-DIMENSION],
            bbob:NUMBER[-DIMENSION], or your own, package.module:attribute.
        output: Folder for the result.
        algorithms: Of `robolaser list algorithms`, as rcga or rcga:b=2; or package.module:attribute. Default: all.
        seeds: Number of runs of each algorithm on each problem, with seeds from --seed on.
        budget: Most evaluations of a run.
        time_limit: Most seconds of a run.
        memory_limit: Most memory of a run [GB].
        jobs: Number of runs at a time. Default: one on each core.
        scheduler: Address of a Dask cluster, tcp://HOST:PORT.
        seed: First seed.
        iohprofiler: Also write the runs in IOHprofiler's format.
        resume: Continue a comparison that was stopped.
        force: Overwrite an earlier result.
    """
    from robolaser.benchmark.engines import DaskCluster, EngineLost, ThisMachine
    from robolaser.benchmark.plan import RunPlan
    from robolaser.benchmark.record import RunRecord
    from robolaser.benchmark.solvers import DEFAULT
    from robolaser.data.result_folder import results_in

    if not datasets:
        raise UsageError("Name a problem, DATASET: see `robolaser compare --help`.")
    if scheduler and jobs:
        raise UsageError("--scheduler and --jobs exclude each other: leave one of them out.")
    if not (resume or force):
        _refuse_to_mix(output)
    plan = RunPlan.of(
        datasets,
        DEFAULT if algorithms is None else [name.strip() for name in algorithms.split(",")],
        seeds=seeds,
        first_seed=seed,
        budget=budget,
        time_limit_s=time_limit,
        memory_limit_b=round(memory_limit * GB),
    )
    files = (RESULT_FILE, RUNS, PAGE)
    with (
        ended_as_by_hand(),
        DaskCluster(scheduler) if scheduler else ThisMachine(jobs) as engine,
        results_in(
            output,
            command="compare",
            files=files,
            state=(RECORD,),
            inputs=[Path(name) for name in datasets if Path(name).is_dir()],
            force=force or resume,
        ) as claim,
    ):
        if not resume:
            (output / RECORD).unlink(missing_ok=True)
        record = RunRecord(output / RECORD)

        try:
            record.begin(plan, engine=engine.label, workers=engine.workers)
            _run(plan, engine, record, terminal)
        except (KeyboardInterrupt, EngineLost) as stopped:
            engine.close()
            with suppress(KeyboardInterrupt):  # the record is there even without the report
                _conclude(plan, record, output, claim if iohprofiler else None, terminal, typed)
            why = str(stopped).rstrip(".") if isinstance(stopped, EngineLost) else "Stopped"
            raise Interrupted(
                f"{why}, after {len(plan.select(record.runs))} of {len(plan.tasks)} runs. They are in"
                f" {output / RECORD}: continue with --resume."
            ) from None
        _conclude(plan, record, output, claim if iohprofiler else None, terminal, typed)


def _refuse_to_mix(output: Path) -> None:
    """Raise if runs or a result would be overwritten."""
    from robolaser.benchmark.record import RunRecord

    if runs := RunRecord(output / RECORD).runs:
        raise OutputError(
            f"{output} holds {len(runs)} runs of a comparison. Continue or extend it with --resume; start over"
            " with --force."
        )


def _run(plan: "RunPlan", engine: "Engine", record: "RunRecord", terminal: Terminal) -> None:
    """Make the runs that are not in the record, and record each as it comes."""
    from robolaser.benchmark.run_loop import run_all

    began = time.monotonic()
    with terminal.progress() as progress:
        for run in run_all(
            plan,
            engine,
            made=plan.select(record.made),
            on_progress=lambda state: progress(_words(state), state.done / max(1, state.wanted)),
        ):
            record.add(run, after_s=time.monotonic() - began)


def _words(state: "RunProgress") -> str:
    """How far a comparison is, and what runs now."""
    running = "; ".join(f"{run.algorithm} on {run.problem}, seed {run.seed}" for run in state.running[:MOST_SHOWN])
    left = "" if state.left_s is None else f"{_duration(state.left_s)} left, "
    return f"{state.done}/{state.wanted} runs, {left}{running or 'waiting for the first worker'}"


def _duration(seconds: float) -> str:
    """A time in hours and minutes, or minutes and seconds."""
    minutes, rest = divmod(round(seconds), 60)
    return f"{minutes // 60} h {minutes % 60} min" if minutes >= 60 else f"{minutes}:{rest:02d}"


def _conclude(
    plan: "RunPlan",
    record: "RunRecord",
    output: Path,
    export_claim: Callable[[Iterable[str]], None] | None,
    terminal: Terminal,
    typed: str,
) -> None:
    """Write and show the result."""
    from robolaser.benchmark.iohprofiler import exported
    from robolaser.benchmark.result_files import comparison_json, runs_csv
    from robolaser.benchmark.standings import standings
    from robolaser.data.result_folder import write_results
    from robolaser.report.comparison import page, print_comparison

    result = plan.result(plan.select(record.runs), record.effort)
    ranked = tuple(standings(result, family) for family in result.families)
    text = comparison_json(result, ranked)
    texts = {RUNS: runs_csv(result), PAGE: page(result, ranked, command=typed), RESULT_FILE: text}
    if export_claim is not None:
        runs = {f"{EXPORT}/{name}": text for name, text in exported(result).items()}
        export_claim(runs)
        texts = runs | texts
    write_results(output, texts)
    terminal.show(text, lambda: print_comparison(result, ranked, output))
