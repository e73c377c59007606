"""robolaser compare: algorithms side by side."""

import argparse
import time
from contextlib import suppress
from pathlib import Path
from typing import TYPE_CHECKING, ClassVar, final

from robolaser.benchmark.terms import BUDGET, MEMORY_LIMIT_B, SEEDS, TIME_LIMIT_S
from robolaser.commands.argument_types import count, positive
from robolaser.commands.command import Command, command_line, make_folder
from robolaser.errors import ClusterLost, ComparisonInterrupted, ComparisonThere, OptionsClash, OutputExists

if TYPE_CHECKING:
    from robolaser.benchmark.engines import Engine
    from robolaser.benchmark.plan import Contest
    from robolaser.benchmark.record import Record

RESULT, RUNS, RECORD, PAGE, EXPORT = "comparison.json", "runs.csv", "runs.jsonl", "report.html", "iohprofiler"
GB = 1e9


@final
class Compare(Command):
    """Lets algorithms run side by side, and says which is better."""

    name: ClassVar[str] = "compare"
    summary: ClassVar[str] = "run algorithms side by side and say which is better, by how much, and how sure that is"

    def declare(self, parser: argparse.ArgumentParser) -> None:
        """Say what can be given to it."""
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
        """Hold the contest, then write and print what came of it, even if it was stopped on the way."""
        from robolaser.benchmark.record import Record  # noqa: PLC0415 - `--help` must not pay for physics

        out: Path = args.output
        if args.scheduler and args.jobs:
            raise OptionsClash("--scheduler", ["--jobs"])
        if not (args.resume or args.force):
            _refuse_what_is_there(out)
        contest = _contest(args)
        with _engine(args) as engine:
            make_folder(out)
            if not args.resume:
                (out / RECORD).unlink(missing_ok=True)
            record = Record(out / RECORD)
            try:
                record.begin(contest, engine=engine.label, workers=engine.workers)
                _hold(contest, engine, record)
            except (KeyboardInterrupt, ClusterLost) as stopped:
                engine.close()
                with suppress(KeyboardInterrupt):  # who cannot wait for the report has the record
                    _conclude(contest, record, args)
                why = str(stopped) if isinstance(stopped, ClusterLost) else "Stopped"
                made = len(contest.own(record.runs))
                raise ComparisonInterrupted(why, out / RECORD, made=made, wanted=len(contest.tasks)) from None
        _conclude(contest, record, args)


def _refuse_what_is_there(out: Path) -> None:
    """Runs and results are overwritten only if somebody says so."""
    from robolaser.benchmark.record import Record  # noqa: PLC0415

    if runs := Record(out / RECORD).runs:
        raise ComparisonThere(out, len(runs))
    if (out / RESULT).exists():
        raise OutputExists(out / RESULT)


def _contest(args: argparse.Namespace) -> "Contest":
    """What was asked for."""
    from robolaser.benchmark.plan import Contest  # noqa: PLC0415
    from robolaser.benchmark.solvers import DEFAULT  # noqa: PLC0415

    return Contest.of(
        args.datasets,
        DEFAULT if args.algorithms is None else [name.strip() for name in args.algorithms.split(",")],
        seeds=args.seeds,
        first_seed=args.seed,
        budget=args.budget,
        time_limit_s=args.time_limit,
        memory_limit_b=round(args.memory_limit * GB),
    )


def _engine(args: argparse.Namespace) -> "Engine":
    """Where it is to be run."""
    from robolaser.benchmark.engines import DaskCluster, ThisMachine  # noqa: PLC0415

    return DaskCluster(args.scheduler) if args.scheduler else ThisMachine(args.jobs)


def _hold(contest: "Contest", engine: "Engine", record: "Record") -> None:
    """Let everybody run whose run is not in the record, and take each run in as it comes."""
    from robolaser.benchmark.run_loop import held  # noqa: PLC0415
    from robolaser.commands.benchmark_progress import contest_progress  # noqa: PLC0415

    began = time.monotonic()
    with contest_progress() as tell:
        for run in held(contest, engine, made=contest.own(record.made), tell=tell):
            record.add(run, after_s=time.monotonic() - began)


def _conclude(contest: "Contest", record: "Record", args: argparse.Namespace) -> None:
    """Write and print what came of it."""
    from robolaser.benchmark.iohprofiler import export  # noqa: PLC0415
    from robolaser.benchmark.results import comparison_json, runs_csv  # noqa: PLC0415
    from robolaser.benchmark.standings import standings  # noqa: PLC0415
    from robolaser.data.csv_tables import write_together  # noqa: PLC0415
    from robolaser.report.comparison import page, print_comparison  # noqa: PLC0415

    out: Path = args.output
    comparison = contest.so_far(contest.own(record.runs), record.effort)
    judged = tuple(standings(comparison, family) for family in comparison.families)
    texts = {
        RUNS: runs_csv(comparison),
        PAGE: page(comparison, judged, command=command_line()),
        RESULT: comparison_json(comparison, judged),
    }
    write_together({out / name: text.encode() for name, text in texts.items()})
    if args.iohprofiler:
        export(comparison, out / EXPORT)
    print_comparison(comparison, judged, out)
