"""robolaser view: a cell in the browser."""

import argparse
import webbrowser
from pathlib import Path
from typing import ClassVar, final

from robolaser.commands.argument_types import LAST_PORT, count
from robolaser.commands.command import Command, warn


@final
class View(Command):
    """Shows arm, scanner, light, target and points, nominal and calibrated."""

    name: ClassVar[str] = "view"
    summary: ClassVar[str] = "show robot, scanner, light sheet, target and points in the browser"

    def declare(self, parser: argparse.ArgumentParser) -> None:
        """Say what can be given to it."""
        parser.add_argument("dataset", metavar="DATASET", type=Path, help="data set or recording")
        parser.add_argument(
            "calibration", metavar="CALIBRATION", type=Path, nargs="?", help="calibration.json or its folder"
        )
        parser.add_argument("--cloud", metavar="CLOUD.ply", type=Path, help="a cloud from `robolaser scan`")
        parser.add_argument("--port", metavar="N", type=port, help="1 to 65535; default: 8080 or the next free one")
        parser.add_argument("--no-browser", action="store_true", help="serve only; open the address yourself")

    def run(self, args: argparse.Namespace) -> None:
        """Serve until interrupted."""
        from robolaser.data.loading import load  # noqa: PLC0415 - `--help` must not pay for physics
        from robolaser.report.viewer.downsampling import thinned  # noqa: PLC0415
        from robolaser.report.viewer.model import Belief, calibrated, nominal  # noqa: PLC0415
        from robolaser.report.viewer.serving import ViewerApp  # noqa: PLC0415
        from robolaser.scan import read_calibration  # noqa: PLC0415
        from robolaser.scan.ply import map_ply  # noqa: PLC0415

        dataset = load(args.dataset)
        beliefs: tuple[Belief, ...] = (nominal(dataset),)
        if args.calibration is not None:
            beliefs = (*beliefs, calibrated(read_calibration(args.calibration), dataset))
        cloud = None if args.cloud is None else thinned(map_ply(args.cloud))
        for warning in (*dataset.warnings, *(note for belief in beliefs for note in belief.notes)):
            warn(warning)
        stage = ViewerApp(beliefs, cloud, args.port)
        print(f"{dataset.name} is at {stage.url}; stop with Ctrl-C.", flush=True)
        if not args.no_browser:
            webbrowser.open(stage.url)
        try:
            stage.wait()
        except KeyboardInterrupt:
            stage.stop()


def port(text: str) -> int:
    """The number of a port, as typed."""
    number = count(text)
    if number > LAST_PORT:
        raise argparse.ArgumentTypeError(f"{text}, expected a whole number from 1 to {LAST_PORT}")
    return number
