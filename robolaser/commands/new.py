"""robolaser new: a cell to begin with."""

from pathlib import Path
from typing import Annotated

from cyclopts import App, Parameter

from robolaser.commands.terminal import RESULT, Count, Force, Terminal, say

new = App("new", help="Write a new cell: its files, a board to print, and plans of poses and motions.")


@new.command
def cell(
    name: str,
    /,
    *,
    camera: bool = False,
    lerobot: Annotated[Path | None, Parameter(metavar="CALIBRATION.json")] = None,
    poses: Count = 20,
    output: Annotated[Path | None, Parameter(metavar="CELL", group=RESULT)] = None,
    force: Force = False,
    terminal: Terminal = Terminal(),
) -> None:
    """Write a cell for a known arm: its files, a board to print, plans of poses and motions, and the next steps.

    For example:

        robolaser new cell so101 --camera

    Args:
        name: The arm, one of `robolaser list robots`.
        camera: The arm carries a camera. Default: a stripe scanner, which is a camera and a laser.
        lerobot: LeRobot's calibration of this arm; joint angles are then those that LeRobot reads.
        poses: Number of poses.
        output: Folder for the cell. Default: NAME-cell.
    """
    from robolaser.bounded_reading import read_text
    from robolaser.cell.new_cell import CELL_FILES, NewCell, new_cell
    from robolaser.data.lerobot import read_servos
    from robolaser.data.result_folder import results_in, write_results
    from robolaser.errors import UsageError
    from robolaser.robot.by_name import entry_of

    entry = entry_of(name)
    if lerobot is not None and entry.controller.get("kind") != "feetech":
        raise UsageError(f"--lerobot is for arms of Feetech servos, which {entry.title} is not: leave it out.")
    servos = {} if lerobot is None else read_servos(read_text(lerobot), entry.joints, lerobot.name)
    wanted = NewCell(entry, "camera" if camera else "stripe", poses, servos)
    folder = Path(f"{entry.name}-cell") if output is None else output
    read = [] if lerobot is None else [lerobot]
    with results_in(folder, command="new cell", files=CELL_FILES, inputs=read, force=force):
        with terminal.progress() as progress:
            progress("planning poses", 0.0)
            files = new_cell(wanted)
        write_results(folder, files)
    written = [file for file in CELL_FILES if files[file] is not None]
    terminal.show(
        {"cell": str(folder), "files": written},
        lambda: say(f"Wrote {', '.join(written)} to {folder}. Next: print board.pdf at 100 %, and read README.md."),
    )
