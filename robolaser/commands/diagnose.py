"""robolaser diagnose: why the robot does not do what the model says."""

import argparse
import json
from pathlib import Path
from typing import ClassVar, final

from robolaser.commands.argument_types import seed
from robolaser.commands.command import Command, command_line, make_folder, progress_bar, warn
from robolaser.errors import Interrupted, OutputExists

RESULT = "diagnosis.json"


@final
class Diagnose(Command):
    """Finds where the gap lies, which effects cause it, and how far it shrinks."""

    name: ClassVar[str] = "diagnose"
    summary: ClassVar[str] = "say why the robot does not do what the model says: where, which effects, how far"

    def declare(self, parser: argparse.ArgumentParser) -> None:
        """Say what can be given to it."""
        parser.add_argument(
            "dataset", metavar="DATASET", type=Path, help="folder with dataset.toml, poses.csv, points.csv"
        )
        parser.add_argument("--output", metavar="DIR", type=Path, required=True, help="folder for the result")
        parser.add_argument(
            "--without",
            metavar="EFFECT",
            action="append",
            default=[],
            help="take an effect out of the library, see `list effects`",
        )
        parser.add_argument("--seed", metavar="N", type=seed, default=1, help="default: 1")
        parser.add_argument("--force", action="store_true", help="overwrite a result that is there")

    def run(self, args: argparse.Namespace) -> None:
        """Diagnose, write and print the result, and the corrected model with it."""
        from robolaser.calibration.export import camera_yaml, corrected_urdf, robot_urdf  # noqa: PLC0415
        from robolaser.data.csv_tables import write_together  # noqa: PLC0415
        from robolaser.data.loading import load  # noqa: PLC0415
        from robolaser.diagnosis import examine  # noqa: PLC0415 - `--help` must not pay for physics
        from robolaser.diagnosis.corrected_model import corrected, corrected_json  # noqa: PLC0415
        from robolaser.report.diagnosis import page, print_diagnosis  # noqa: PLC0415

        out: Path = args.output
        for name in (RESULT, "calibration.json"):
            if (out / name).exists() and not args.force:
                raise OutputExists(out / name)
        dataset = load(args.dataset)
        make_folder(out)
        try:
            with progress_bar() as progress:
                found = examine(dataset, seed=args.seed, without=tuple(args.without), progress=progress)
            for warning in dataset.warnings:
                warn(warning)
            model = corrected(found, args.seed)
            texts = {
                "robot.urdf": robot_urdf(model),
                "robot_corrected.urdf": corrected_urdf(model),
                "camera.yaml": camera_yaml(model) if dataset.kind == "stripe" else None,
                "calibration.json": corrected_json(model),
                "report.html": page(found, command=command_line()),
                RESULT: json.dumps(found.as_json(), indent=1, allow_nan=False, ensure_ascii=False) + "\n",
            }
            write_together({out / name: text.encode() for name, text in texts.items() if text is not None})
            for name in (name for name, text in texts.items() if text is None):
                (out / name).unlink(missing_ok=True)  # of the result that was here before
        except KeyboardInterrupt:
            raise Interrupted(None) from None
        print_diagnosis(found, out)
