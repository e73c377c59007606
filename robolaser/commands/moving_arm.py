"""What `calibrate` and `diagnose` do with the log of a moving arm."""

from collections.abc import Callable
from pathlib import Path
from typing import TYPE_CHECKING

from robolaser.arrays import Progress
from robolaser.commands.terminal import Terminal

if TYPE_CHECKING:
    from robolaser.motion.log import MotionLog
    from robolaser.results import FittedResult


def found_in(
    log: "MotionLog", find: "Callable[[Progress], FittedResult]", output: Path, terminal: Terminal, typed: str
) -> "FittedResult":
    """A result with its files written.

    Args:
        log: What was recorded.
        find: Makes the result, and tells of its progress.
        output: The folder of the files.
        terminal: Where warnings and the progress are shown.
        typed: The command, as it was typed.
    """
    from robolaser.data.result_folder import write_results

    terminal.warn(*log.warnings)
    with terminal.progress() as progress:
        found = find(progress)
    write_results(output, found.files(command=typed))
    return found
