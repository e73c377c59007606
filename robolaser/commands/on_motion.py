"""What `calibrate` and `diagnose` do alike with a log of a moving arm."""

from collections.abc import Callable, Sequence
from pathlib import Path
from typing import TYPE_CHECKING

from robolaser.commands.terminal import Terminal

if TYPE_CHECKING:
    from robolaser.arrays import Progress
    from robolaser.motion.log import MotionLog
    from robolaser.results import FittedResult


def on_motion(
    make: "Callable[[MotionLog, Progress], FittedResult]",
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

    log = load_motion(dataset)
    with results_in(output, command=command, files=files, inputs=[dataset], force=force):
        terminal.warn(*log.warnings)
        with terminal.progress() as progress:
            result = make(log, progress)
        texts = result.files(command=typed)
        write_results(output, texts)
    terminal.show(texts[files[0]] or "", lambda: result.print(output))
