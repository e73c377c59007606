"""A cloud in a few lines on the terminal."""

from pathlib import Path

from rich.console import Console
from rich.text import Text

from robolaser.report.cloud.figures import figures, heading
from robolaser.report.console import plain_unless_terminal, print_figures
from robolaser.report.document import Figures
from robolaser.scan import Scan
from robolaser.scan.quality import Quality


def print_cloud(scan: Scan, quality: Quality, *written: Path, console: Console | None = None) -> None:
    """Print what a scan gave.

    Args:
        scan: Done.
        quality: Of its cloud.
        written: Where it is to be found.
        console: Where to print; standard output by default.
    """
    out = plain_unless_terminal(console)
    out.print(Text(f"{scan.recording.name}: {heading(scan)}", style="bold"))
    print_figures(Figures(figures(scan, quality)), out)
    out.print(Text(f"Wrote {' and '.join(map(str, written))}"))
