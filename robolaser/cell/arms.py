"""The languages that arms speak, by name; to add one is to add a file with an `Arm` and a line here."""

from collections.abc import Callable, Mapping
from dataclasses import dataclass
from typing import final

from robolaser.cell.arm import Arm
from robolaser.cell.clock import Clock
from robolaser.data.cell_config import FILE, Cell
from robolaser.data.toml_schema import wrong
from robolaser.errors import DataError, near


@final
@dataclass(frozen=True)
class ArmKind:
    """One way of speaking to an arm.

    Attributes:
        open: Opens the line of a cell's arm.
        outputs: How many digital outputs its controller has, counted from 1; None: whatever is asked of it.
    """

    open: Callable[[Cell, Clock], Arm]
    outputs: int | None


def _acl(cell: Cell, clock: Clock) -> Arm:
    from robolaser.cell.acl import AclArm  # noqa: PLC0415 - only the one that is there is loaded

    return AclArm.open(cell.arm, cell.robot.joints, clock)


def _lss(cell: Cell, clock: Clock) -> Arm:
    from robolaser.cell.lss import LssArm  # noqa: PLC0415

    return LssArm.open(cell.arm, cell.robot.joints, clock)


def _replay(cell: Cell, clock: Clock) -> Arm:
    from robolaser.cell.replay import ReplayArm  # noqa: PLC0415

    return ReplayArm(cell.beside(cell.arm.port), cell.robot.joints)


ARMS: Mapping[str, ArmKind] = {"acl": ArmKind(_acl, 16), "lss": ArmKind(_lss, 0), "replay": ArmKind(_replay, None)}
"""By the `kind` in cell.toml: SCORBOT controllers, Lynxmotion smart servos, and a recording that passes for an arm."""


def arm_kind_of(cell: Cell) -> ArmKind:
    """The language of a cell's arm, its port and the laser's output having been looked at. Nothing is opened.

    Raises:
        DataError: No kind of that name; its controller does not have the output that switches the laser; no port is
            named.
    """
    if cell.arm.kind not in ARMS:
        raise DataError(
            f"{FILE}, [arm] kind: no arm speaks '{cell.arm.kind}'.{near(cell.arm.kind, ARMS)}", file=FILE, column="kind"
        )
    language, output = ARMS[cell.arm.kind], cell.laser_output
    if output is not None and language.outputs is not None and output > language.outputs:
        there = f"has outputs 1 to {language.outputs}" if language.outputs else "switches nothing; take [laser] out"
        raise DataError(
            f"{FILE}, [laser] output: {output}, but an arm of kind '{cell.arm.kind}' {there}.",
            file=FILE,
            column="output",
        )
    if not cell.arm.port:
        raise wrong(FILE, ("arm", "port"), cell.arm.port, "a device, or any URL that pyserial opens")
    return language


def open_arm(cell: Cell, clock: Clock) -> Arm:
    """Open the line to a cell's arm. Nothing moves.

    Raises:
        DataError: See `arm_kind_of`; or dataset.toml has a robot with more joints than the controller moves.
        RobolaserError: The port, the line or the controller says no.
    """
    return arm_kind_of(cell).open(cell, clock)
