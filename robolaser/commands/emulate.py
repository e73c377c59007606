"""robolaser emulate: an emulated cell."""

from pathlib import Path
from typing import Annotated

from cyclopts import Parameter
from cyclopts.validators import Number

from robolaser.commands.terminal import Seed, Terminal

FASTEST = 1000.0


def emulate(
    cell: Path,
    /,
    *,
    world: Annotated[Path | None, Parameter(metavar="WORLD.toml")] = None,
    time_scale: Annotated[float, Parameter(metavar="N", validator=Number(gt=0, lte=FASTEST))] = 1.0,
    seed: Seed = 1,
    faults: Annotated[tuple[str, ...], Parameter(name="--fault", metavar="KIND[:AMOUNT][@WHEN]")] = (),
    terminal: Terminal = Terminal(),
) -> None:
    """Serve an emulated cell: the arm's serial line and the camera, with faults on demand.

    It prints one line of JSON with the addresses of arm and camera, and runs until it is stopped. For example:

        robolaser emulate cell --world world.toml --fault lost:0.1

    Args:
        cell: Folder with cell.toml, dataset.toml and the URDF.
        world: The true state of the cell; without it, there is no camera.
        time_scale: How many times as fast as real time its clock runs.
        faults: For example lost:0.1, impact:3@12 (at the 12th command), silent@>5s; may be given again.
    """
    from robolaser.emulator.emulated_cell import EmulatedCell, serve

    serve(EmulatedCell(cell, world=world, time_scale=time_scale, seed=seed, faults=faults))
