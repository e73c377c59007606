"""A calibration in a few lines on the terminal."""

from pathlib import Path

from rich.console import Console
from rich.text import Text

from robolaser.calibration.result import Calibration
from robolaser.report.calibration.page import document
from robolaser.report.console import plain_unless_terminal, print_document, print_page

FOR_ROS = ("camera.yaml", "robot.urdf", "static_transform.sh", "easy_handeye2.calib")


def print_summary(calibration: Calibration, folder: Path | None = None, *, console: Console | None = None) -> None:
    """Print errors, parameters and where the page is; plain text unless on a terminal.

    Args:
        calibration: The result.
        folder: Where it was written.
        console: Where to print; standard output by default.
    """
    out = plain_unless_terminal(console)
    print_document(document(calibration, brief=True), out)
    together = [", ".join(found.parameters) for found in calibration.unidentifiable if len(found.parameters) > 1]
    alone = [found.parameters[0] for found in calibration.unidentifiable if len(found.parameters) == 1]
    if together:
        out.print(Text(f"These data cannot separate: {'; '.join(together)}", style="dim"))
    if alone:
        out.print(Text(f"These data hardly determine: {', '.join(alone)}", style="dim"))
    if folder is not None:
        if (folder / "static_transform.sh").exists():
            *files, last = (name for name in FOR_ROS if (folder / name).exists())
            out.print(Text(f"For ROS: {', '.join(files)} and {last} in {folder}", style="dim"))
        print_page(folder, out)
