"""What `calibrate` and `diagnose` do alike with a log of a moving arm."""

from collections.abc import Callable, Sequence
from pathlib import Path
from typing import TYPE_CHECKING, TypeVar

from robolaser.commands.terminal import Terminal

if TYPE_CHECKING:
    from robolaser.arrays import Progress
    from robolaser.motion.log import MotionLog
    from robolaser.report.document import Document
    from robolaser.results import FittedResult

R = TypeVar("R", bound="FittedResult")


def on_motion(
    make: "Callable[[MotionLog, Progress], R]",
    document: "Callable[[R], Document]",
    dataset: Path,
    output: Path,
    files: Sequence[str],
    *,
    command: str,
    force: bool,
    terminal: Terminal,
    typed: str,
) -> None:
    """Make a result of a log, write its files, and show it: the first of them as JSON, or what people read."""
    from robolaser.data.result_folder import results_in, write_results
    from robolaser.motion.reading import load_motion
    from robolaser.report.console import print_document

    log = load_motion(dataset)
    with results_in(output, command=command, files=files, inputs=[dataset], force=force):
        terminal.warn(*log.warnings)
        with terminal.progress() as progress:
            result = make(log, progress)
        texts = result.files(command=typed)
        write_results(output, texts)
    terminal.show(texts[files[0]] or "", lambda: print_document(document(result), output))
