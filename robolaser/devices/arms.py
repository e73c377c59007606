"""The languages that arms speak, by name; to add one is to add a file with an `Arm` and a line here."""

from collections.abc import Callable, Mapping

from robolaser.cell import Cell
from robolaser.devices.arm import Arm
from robolaser.devices.clock import Clock
from robolaser.errors import ArmUnknown


def _acl(cell: Cell, joints: tuple[str, ...], clock: Clock) -> Arm:
    from robolaser.devices.acl import Acl  # noqa: PLC0415 - only the one that is there is loaded

    return Acl.open(cell.arm, joints, clock)


def _lss(cell: Cell, joints: tuple[str, ...], clock: Clock) -> Arm:
    from robolaser.devices.lss import Lss  # noqa: PLC0415

    return Lss.open(cell.arm, joints, clock)


def _replay(cell: Cell, joints: tuple[str, ...], clock: Clock) -> Arm:
    from robolaser.devices.replay import Replay  # noqa: PLC0415

    return Replay(cell.beside(cell.arm.port), joints)


ARMS: Mapping[str, Callable[[Cell, tuple[str, ...], Clock], Arm]] = {"acl": _acl, "lss": _lss, "replay": _replay}
"""By the `kind` in cell.toml: SCORBOT controllers, Lynxmotion smart servos, and a recording that passes for an arm."""


def open_arm(cell: Cell, clock: Clock) -> Arm:
    """Open the line to a cell's arm. Nothing moves.

    Raises:
        ArmUnknown: No language of that name.
        ArmDiffers: dataset.toml has no robot, or one with more joints than the controller moves.
        RobolaserError: The port, the line or the controller says no.
    """
    if cell.arm.kind not in ARMS:
        raise ArmUnknown(cell.arm.kind, ARMS)
    robot = cell.description.robot
    return ARMS[cell.arm.kind](cell, () if robot is None else robot.joints, clock)
