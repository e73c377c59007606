"""robolaser compare: algorithms side by side."""

import argparse
import shlex
import time
from contextlib import suppress
from pathlib import Path
from typing import TYPE_CHECKING, ClassVar, final

from robolaser.benchmark.defaults import BUDGET, MEMORY_LIMIT_B, SEEDS, TIME_LIMIT_S
from robolaser.commands.argument_types import count, positive
from robolaser.commands.command import Command, make_folder
from robolaser.errors import BenchmarkError, OptionsClash, OutputError, OutputExists

if TYPE_CHECKING:
    from robolaser.benchmark.engines import Engine
    from robolaser.benchmark.plan import RunPlan
    from robolaser.benchmark.record import RunRecord

RESULT, RUNS, RECORD, PAGE, EXPORT = "comparison.json", "runs.csv", "runs.jsonl", "report.html", "iohprofiler"
GB = 1e9


@final
class Compare(Command):
    """Runs algorithms side by side, and reports which is better."""

    name: ClassVar[str] = "compare"
    summary: ClassVar[str] = "run algorithms side by side and say which is better, by how much, and how sure that is"

    def declare(self, parser: argparse.ArgumentParser) -> None:
        """Declare its arguments."""
        parser.add_argument(
            "datasets",
            metavar="DATASET",
            nargs="+",
            help="a problem each: folder of a data set, or `paper`, either with `reduced:` before it for its"
            " closed-form reduction; or pymoo:NAME[-DIMENSION], a test function",
        )
        parser.add_argument("--output", metavar="DIR", type=Path, required=True, help="folder for the result")
        parser.add_argument(
            "--algorithms",
            metavar="A,B",
            help="names, see `list algorithms`, with settings as in rcga:b=2:n_elites=0, or package.module:attribute;"
            " default: all by their plain names",
        )
        parser.add_argument("--seeds", metavar="N", type=count, default=SEEDS, help=f"default: {SEEDS}, from --seed on")
        parser.add_argument(
            "--budget", metavar="EVALS", type=count, default=BUDGET, help=f"evaluations a run; default: {BUDGET}"
        )
        parser.add_argument(
            "--time-limit",
            metavar="S",
            type=positive,
            default=TIME_LIMIT_S,
            help=f"of a run; default: {TIME_LIMIT_S:g}",
        )
        parser.add_argument(
            "--memory-limit",
            metavar="GB",
            type=positive,
            default=MEMORY_LIMIT_B / GB,
            help=f"of a run; default: {MEMORY_LIMIT_B / GB:g}",
        )
        parser.add_argument("--jobs", metavar="N", type=count, help="runs at a time; default: one on each core")
        parser.add_argument("--scheduler", metavar="ADDRESS", help="of a Dask cluster, tcp://HOST:PORT")
        parser.add_argument("--seed", metavar="N", type=count, default=1, help="the first of the seeds; default: 1")
        parser.add_argument("--iohprofiler", action="store_true", help="write the runs in IOHprofiler's format too")
        parser.add_argument("--resume", action="store_true", help="go on with a comparison that was stopped")
        parser.add_argument("--force", action="store_true", help="overwrite a result that is there")

    def run(self, args: argparse.Namespace) -> None:
        """Make all runs, then write and print the result, even if the runs were stopped."""
        from robolaser.benchmark.engines import EngineLost  # noqa: PLC0415 - `--help` must not pay for physics
        from robolaser.benchmark.record import RunRecord  # noqa: PLC0415

        out: Path = args.output
        if args.scheduler and args.jobs:
            raise OptionsClash("--scheduler", ["--jobs"])
        if not (args.resume or args.force):
            _refuse_what_is_there(out)
        plan = _plan(args)
        with _engine(args) as engine:
            make_folder(out)
            if not args.resume:
                (out / RECORD).unlink(missing_ok=True)
            record = RunRecord(out / RECORD)
            try:
                record.begin(plan, engine=engine.label, workers=engine.workers)
                _run(plan, engine, record)
            except (KeyboardInterrupt, EngineLost) as stopped:
                engine.close()
                with suppress(KeyboardInterrupt):  # the record is there even without the report
                    _conclude(plan, record, args)
                why = str(stopped) if isinstance(stopped, EngineLost) else "Stopped"
                made = len(plan.select(record.runs))
                raise BenchmarkError(
                    f"{why.rstrip('.')}, after {made} of {len(plan.tasks)} runs. They are in {out / RECORD}: go on with"
                    " --resume."
                ) from None
        _conclude(plan, record, args)


def _refuse_what_is_there(out: Path) -> None:
    """Runs and results are overwritten only with --force."""
    from robolaser.benchmark.record import RunRecord  # noqa: PLC0415

    if runs := RunRecord(out / RECORD).runs:
        raise OutputError(
            f"{out} holds {len(runs)} runs of a comparison. Go on with it, or add to it, with --resume; begin anew with"
            " --force."
        )
    if (out / RESULT).exists():
        raise OutputExists(out / RESULT)


def _plan(args: argparse.Namespace) -> "RunPlan":
    """The planned runs."""
    from robolaser.benchmark.plan import RunPlan  # noqa: PLC0415
    from robolaser.benchmark.solvers import DEFAULT  # noqa: PLC0415

    return RunPlan.of(
        args.datasets,
        DEFAULT if args.algorithms is None else [name.strip() for name in args.algorithms.split(",")],
        seeds=args.seeds,
        first_seed=args.seed,
        budget=args.budget,
        time_limit_s=args.time_limit,
        memory_limit_b=round(args.memory_limit * GB),
    )


def _engine(args: argparse.Namespace) -> "Engine":
    """Where the runs are made."""
    from robolaser.benchmark.engines import DaskCluster, ThisMachine  # noqa: PLC0415

    return DaskCluster(args.scheduler) if args.scheduler else ThisMachine(args.jobs)


def _run(plan: "RunPlan", engine: "Engine", record: "RunRecord") -> None:
    """Make all runs that are not in the record, and record each as it is done."""
    from robolaser.benchmark.run_loop import run_all  # noqa: PLC0415
    from robolaser.commands.benchmark_progress import benchmark_progress  # noqa: PLC0415

    began = time.monotonic()
    with benchmark_progress() as show:
        for run in run_all(plan, engine, made=plan.select(record.made), on_progress=show):
            record.add(run, after_s=time.monotonic() - began)


def _conclude(plan: "RunPlan", record: "RunRecord", args: argparse.Namespace) -> None:
    """Write and print the result."""
    from robolaser.benchmark.iohprofiler import export  # noqa: PLC0415
    from robolaser.benchmark.result_files import comparison_json, runs_csv  # noqa: PLC0415
    from robolaser.benchmark.standings import standings  # noqa: PLC0415
    from robolaser.data.csv_tables import write_together  # noqa: PLC0415
    from robolaser.report.comparison import page, print_comparison  # noqa: PLC0415

    out: Path = args.output
    result = plan.result(plan.select(record.runs), record.effort)
    ranked = tuple(standings(result, family) for family in result.families)
    texts = {
        RUNS: runs_csv(result),
        PAGE: page(result, ranked, command=_again(args)),
        RESULT: comparison_json(result, ranked),
    }
    write_together({out / name: text.encode() for name, text in texts.items()})
    if args.iohprofiler:
        export(result, out / EXPORT)
    print_comparison(result, ranked, out)


def _again(args: argparse.Namespace) -> str:
    """What to type to repeat it."""
    words = ["robolaser", "compare", *args.datasets, "--output", str(args.output)]
    if args.algorithms is not None:
        words += ["--algorithms", args.algorithms]
    words += ["--seeds", str(args.seeds), "--budget", str(args.budget)]
    for option, value, usual in (
        ("--time-limit", args.time_limit, TIME_LIMIT_S),
        ("--memory-limit", args.memory_limit, MEMORY_LIMIT_B / GB),
        ("--jobs", args.jobs, None),
        ("--scheduler", args.scheduler, None),
        ("--seed", args.seed, 1),
    ):
        if value != usual:
            words += [option, f"{value:g}" if isinstance(value, float) else str(value)]
    return shlex.join([*words, "--iohprofiler"] if args.iohprofiler else words)
