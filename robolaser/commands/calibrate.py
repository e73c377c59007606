"""robolaser calibrate: from points to parameters."""

import argparse
from pathlib import Path
from typing import ClassVar, final

from robolaser.commands.argument_types import count, seed
from robolaser.commands.command import Command, command_line, make_folder, progress_bar, warn
from robolaser.errors import Interrupted, OutputExists, SearchStopped

RESULT = "calibration.json"


@final
class Calibrate(Command):
    """Finds the parameters."""

    name: ClassVar[str] = "calibrate"
    summary: ClassVar[str] = "find the parameters of scanner, base, tool or sockets from measured points"

    def declare(self, parser: argparse.ArgumentParser) -> None:
        """Say what can be given to it."""
        parser.add_argument(
            "dataset", metavar="DATASET", type=Path, help="folder with dataset.toml, poses.csv, points.csv"
        )
        parser.add_argument("--output", metavar="DIR", type=Path, required=True, help="folder for the result")
        parser.add_argument("--algorithm", metavar="NAME", help="default: screening; see `robolaser list algorithms`")
        parser.add_argument(
            "--no-polish", action="store_true", help="leave out the Gauss-Newton steps after the search"
        )
        parser.add_argument(
            "--weights", choices=("plain", "noise"), default="plain", help="default: plain, J as it stands"
        )
        parser.add_argument(
            "--loss",
            choices=("square", "huber", "cauchy"),
            default="square",
            help="huber and cauchy let gross errors count for less; default: square",
        )
        parser.add_argument(
            "--with",
            metavar="EFFECT[:WHERE]",
            dest="effects",
            action="append",
            default=[],
            help="add an effect to the model",
        )
        parser.add_argument("--generations", metavar="N", type=count, help="of a search that has any")
        parser.add_argument("--seed", metavar="N", type=seed, default=1, help="default: 1")
        parser.add_argument("--resume", action="store_true", help="go on with a search that was stopped")
        parser.add_argument("--force", action="store_true", help="overwrite a result that is there")

    def run(self, args: argparse.Namespace) -> None:
        """Calibrate, write and print the result."""
        from robolaser.algorithms.registry import POLISH_ONLY, SCREENING  # noqa: PLC0415 - `--help` must not pay for physics
        from robolaser.calibration.calibrate import calibrate  # noqa: PLC0415
        from robolaser.calibration.export import camera_yaml, corrected_urdf, robot_urdf  # noqa: PLC0415
        from robolaser.calibration.options import GENERATIONS, Plan  # noqa: PLC0415
        from robolaser.calibration.pymoo_search import CHECKPOINT, COURSE  # noqa: PLC0415
        from robolaser.calibration.result import json_text  # noqa: PLC0415
        from robolaser.data.csv_tables import write_together  # noqa: PLC0415
        from robolaser.data.loading import load  # noqa: PLC0415
        from robolaser.report.calibration import page, print_summary  # noqa: PLC0415

        out: Path = args.output
        if (out / RESULT).exists() and not args.force:
            raise OutputExists(out / RESULT)
        if (out / CHECKPOINT).exists() and not (args.resume or args.force):
            raise SearchStopped(out)
        if args.generations and args.algorithm in (None, SCREENING, POLISH_ONLY):
            warn(f"--generations changes nothing: {args.algorithm or 'the default search'} has none.")
        dataset = load(args.dataset)
        make_folder(out)
        plan = Plan(
            algorithm=args.algorithm,
            polish=not args.no_polish,
            weights=args.weights,
            loss=args.loss,
            effects=tuple(args.effects),
            seed=args.seed,
            generations=args.generations or GENERATIONS,
        )
        try:
            with progress_bar() as progress:
                found = calibrate(dataset, plan, state=out, resume=args.resume, progress=progress)
            for warning in found.warnings:
                warn(warning)
            texts = {
                "robot.urdf": robot_urdf(found),
                "robot_corrected.urdf": corrected_urdf(found),
                "camera.yaml": camera_yaml(found) if dataset.kind == "stripe" else None,
                "report.html": page(found, command=command_line()),
                RESULT: json_text(found),
            }
            write_together({out / name: text.encode() for name, text in texts.items() if text is not None})
        except KeyboardInterrupt:
            raise Interrupted(out if (out / CHECKPOINT).exists() else None) from None
        for state in (CHECKPOINT, COURSE):
            (out / state).unlink(missing_ok=True)
        print_summary(found, out)
