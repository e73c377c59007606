"""The arms that can be driven, by the `kind` in cell.toml: a file with an `Arm` and a line here, or a plugin."""

import pkgutil
from collections.abc import Mapping

from robolaser.cell.arm import Arm
from robolaser.data.cell_config import FILE, Cell
from robolaser.data.toml_schema import wrong
from robolaser.errors import DataError, near
from robolaser.plugins import announced

GROUP = "robolaser.arms"
"""Entry points of installed packages that announce arms; the entry point's name is the kind."""
ARMS: Mapping[str, str] = {
    "acl": "robolaser.cell.acl:AclArm",
    "dynamixel": "robolaser.cell.servos:ServoArm",
    "feetech": "robolaser.cell.servos:ServoArm",
    "lss": "robolaser.cell.lss:LssArm",
    "ur": "robolaser.cell.ur:UrArm",
}
"""SCORBOT controllers, bus servos of three makers, and Universal Robots' arms."""
REQUIRED = ("outputs", "synchronous_read", "absolute_encoders")


def arm_class(cell: Cell) -> type[Arm]:
    """The class of a cell's arm; its port and the output that switches the laser are checked. Nothing is opened.

    Raises:
        DataError: No arm of that kind; its controller does not have the output; no port is named.
        PluginError: An installed package announces an arm that cannot be used.
    """
    kind, output = cell.arm.kind, cell.laser_output
    if kind in ARMS:
        arm: type[Arm] = pkgutil.resolve_name(ARMS[kind])  # the others are not loaded
    else:
        others = announced(GROUP, Arm, taken=ARMS, name="", required=REQUIRED)
        if kind not in others:
            raise DataError(
                f"{FILE}, [arm] kind: no such kind of arm '{kind}'.{near(kind, [*ARMS, *others])}",
                file=FILE,
                column="kind",
            )
        arm = others[kind]
    if cell.arm.setpoint_hz is not None and not arm.follows:
        expected = f"none: an arm of kind '{kind}' plans its motions itself"
        raise wrong(FILE, ("arm", "setpoint_hz"), cell.arm.setpoint_hz, expected)
    if output is not None and arm.outputs is not None and output > arm.outputs:
        there = f"has outputs 1 to {arm.outputs}" if arm.outputs else "switches nothing; take [laser] out"
        raise DataError(
            f"{FILE}, [laser] output: {output}, but an arm of kind '{kind}' {there}.", file=FILE, column="output"
        )
    if not cell.arm.port:
        raise wrong(FILE, ("arm", "port"), cell.arm.port, "a device, or any URL that pyserial opens")
    return arm
