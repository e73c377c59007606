"""robolaser scan: from a calibration and a recording to a cloud of points."""

import argparse
from pathlib import Path
from typing import ClassVar, final

from robolaser.commands.argument_types import positive
from robolaser.commands.command import Command, command_line, make_folder, progress_bar, warn
from robolaser.errors import OutputExists, StoppedLate

ENDING = ".ply"
LEAST_STEP_M = 1e-3  # a few times the distance at which points still count as on a plane


@final
class Scan(Command):
    """Turns the stripes of a recording into points in the base frame."""

    name: ClassVar[str] = "scan"
    summary: ClassVar[str] = "turn a recording into a point cloud with a calibrated scanner"

    def declare(self, parser: argparse.ArgumentParser) -> None:
        """Say what can be given to it."""
        parser.add_argument(
            "calibration", metavar="CALIBRATION", type=Path, help="calibration.json or its folder, with robot.urdf"
        )
        parser.add_argument(
            "recording",
            metavar="RECORDING",
            type=Path,
            help="folder with dataset.toml, poses.csv and stripes.npy, points.csv or images",
        )
        parser.add_argument(
            "--output", metavar="CLOUD.ply", type=cloud_file, required=True, help="the cloud, as binary PLY"
        )
        parser.add_argument(
            "--nominal", action="store_true", help="with the scanner as it was drawn, before anything was fitted"
        )
        parser.add_argument("--plane", action="store_true", help="measure the scatter about the largest plane")
        parser.add_argument(
            "--step",
            metavar="HEIGHT_M",
            type=step_height,
            help=f"measure a step of this height on the largest plane, at least {LEAST_STEP_M:g}",
        )
        parser.add_argument("--sphere", metavar="RADIUS_M", type=positive, help="measure a sphere of this radius")
        parser.add_argument("--report", action="store_true", help="write CLOUD.html beside it, with pictures")
        parser.add_argument("--force", action="store_true", help="overwrite a cloud that is there")

    def run(self, args: argparse.Namespace) -> None:
        """Scan, write the cloud, and say how good it is."""
        from robolaser.data.csv_tables import write_text  # noqa: PLC0415
        from robolaser.data.loading import load  # noqa: PLC0415 - `--help` must not pay for physics
        from robolaser.report.cloud import page, print_cloud  # noqa: PLC0415
        from robolaser.scan import prepare, read_calibration  # noqa: PLC0415
        from robolaser.scan.ply import write_ply  # noqa: PLC0415
        from robolaser.scan.quality import measure  # noqa: PLC0415
        from robolaser.scan.subsample import Survey  # noqa: PLC0415

        files: list[Path] = [args.output, *([args.output.with_suffix(".html")] if args.report else [])]
        for path in files:
            if path.exists() and not args.force:
                raise OutputExists(path)
        calibrated = read_calibration(args.calibration)
        scan = prepare(calibrated.as_drawn() if args.nominal else calibrated, load(args.recording))
        make_folder(args.output.parent)
        for warning in (*scan.recording.warnings, *scan.warnings):
            warn(warning)
        survey = Survey()
        with progress_bar() as progress:
            pieces = survey.watch(scan.cloud.pieces(progress))
            write_ply(args.output, pieces, scan.comments(), overwrite=args.force)
        wanted = [what for what in ("plane", "step", "sphere") if getattr(args, what)]
        try:
            quality = measure(survey.vertices, wanted=wanted, step_m=args.step or 0.0, sphere_m=args.sphere or 0.0)
            if args.report:
                write_text(files[1], page(scan, quality, command=command_line()))
        except KeyboardInterrupt:
            raise StoppedLate(str(args.output), "what is measured on it") from None
        print_cloud(scan, quality, *files)
        for doubt in quality.doubts:
            warn(doubt)
        for missing in quality.missing[1:]:
            warn(str(missing))
        for missing in quality.missing[:1]:
            raise missing


def step_height(text: str) -> float:
    """The height of a step, as typed."""
    height = positive(text)
    if height < LEAST_STEP_M:
        raise argparse.ArgumentTypeError(
            f"{text}, expected at least {LEAST_STEP_M:g}: less is as near as points of one plane are"
        )
    return height


def cloud_file(text: str) -> Path:
    """The name of a cloud, as typed."""
    if not text.lower().endswith(ENDING):
        raise argparse.ArgumentTypeError(f"{text}, expected a name that ends with {ENDING}")
    return Path(text)
