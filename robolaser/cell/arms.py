"""The languages that arms speak, by name; to add one is to add a file with an `Arm` and a line here."""

from collections.abc import Callable, Mapping
from dataclasses import dataclass
from typing import final

from robolaser.cell.arm import Arm
from robolaser.cell.clock import Clock
from robolaser.data.cell_config import FILE, Cell
from robolaser.data.toml_schema import wrong
from robolaser.errors import ArmUnknown, OutputMissing


@final
@dataclass(frozen=True)
class Language:
    """One way of speaking to an arm.

    Attributes:
        open: Opens the line of a cell's arm.
        outputs: How many digital outputs its controller has, counted from 1; None: whatever is asked of it.
    """

    open: Callable[[Cell, Clock], Arm]
    outputs: int | None


def _acl(cell: Cell, clock: Clock) -> Arm:
    from robolaser.cell.acl import Acl  # noqa: PLC0415 - only the one that is there is loaded

    return Acl.open(cell.arm, cell.robot.joints, clock)


def _lss(cell: Cell, clock: Clock) -> Arm:
    from robolaser.cell.lss import Lss  # noqa: PLC0415

    return Lss.open(cell.arm, cell.robot.joints, clock)


def _replay(cell: Cell, clock: Clock) -> Arm:
    from robolaser.cell.replay import Replay  # noqa: PLC0415

    return Replay(cell.beside(cell.arm.port), cell.robot.joints)


ARMS: Mapping[str, Language] = {"acl": Language(_acl, 16), "lss": Language(_lss, 0), "replay": Language(_replay, None)}
"""By the `kind` in cell.toml: SCORBOT controllers, Lynxmotion smart servos, and a recording that passes for an arm."""


def language_of(cell: Cell) -> Language:
    """The language of a cell's arm, its port and the laser's output having been looked at. Nothing is opened.

    Raises:
        ArmUnknown: No language of that name.
        OutputMissing: Its controller does not have the output that switches the laser.
        DataError: No port is named.
    """
    if cell.arm.kind not in ARMS:
        raise ArmUnknown(cell.arm.kind, ARMS)
    language, output = ARMS[cell.arm.kind], cell.laser_output
    if output is not None and language.outputs is not None and output > language.outputs:
        raise OutputMissing(cell.arm.kind, output, language.outputs)
    if not cell.arm.port:
        raise wrong(FILE, ("arm", "port"), cell.arm.port, "a device, or any URL that pyserial opens")
    return language


def open_arm(cell: Cell, clock: Clock) -> Arm:
    """Open the line to a cell's arm. Nothing moves.

    Raises:
        ArmUnknown, OutputMissing, DataError: See `language_of`.
        ArmDiffers: dataset.toml has a robot with more joints than the controller moves.
        RobolaserError: The port, the line or the controller says no.
    """
    return language_of(cell).open(cell, clock)
