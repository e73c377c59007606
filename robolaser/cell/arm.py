"""The interface of arms: they move to joint angles and are read, whatever their controller's protocol.

An arm is a file with an `Arm` and a line in `ARMS`, or a plugin; cell.toml names it by its `kind`.
"""

import pkgutil
from abc import ABC, abstractmethod
from collections.abc import Mapping
from typing import ClassVar, Self

from robolaser.arrays import Array
from robolaser.cell.clock import Clock
from robolaser.data.cell_config import FILE, Cell
from robolaser.data.toml_schema import wrong
from robolaser.errors import ArmError, DataError
from robolaser.plugins import announced

GROUP = "robolaser.arms"  # entry points of installed packages that announce arms; the entry point's name is the kind
ARMS: Mapping[str, str] = {
    "acl": "robolaser.cell.acl:AclArm",
    "dynamixel": "robolaser.cell.servos:ServoArm",
    "feetech": "robolaser.cell.servos:ServoArm",
    "lss": "robolaser.cell.lss:LssArm",
    "replay": "robolaser.cell.replay:ReplayArm",
    "ur": "robolaser.cell.ur:UrArm",
}
"""SCORBOT controllers, bus servos of three makers, a recording in place of an arm, and Universal Robots' arms."""
REQUIRED = ("outputs", "synchronous_read", "absolute_encoders")


class Arm(ABC):
    """One arm on one line.

    Angles are in the order of the joints of the cell's robot.

    Raises (every method): LineLost, and of `robolaser.cell.failures` AnswerUnclear, ArmAlarm and
    ArmRestarted; ArmError where a device sends without end, or its controller rejects a command.
    """

    step: Array
    """The smallest difference of angles that a reading resolves, (j,) [rad or m]."""
    synchronous_read: ClassVar[bool]
    """Whether a reading shows all joints at one instant, not one after the other."""
    outputs: ClassVar[int | None]
    """Number of its controller's digital outputs, which count from 1; None: any number is accepted."""
    absolute_encoders: ClassVar[bool]
    """Whether its readings mean the same angles after its power was off."""
    stops_alone: ClassVar[bool] = False
    """Whether it stops by itself within a second after communication ends."""
    follows: ClassVar[bool] = False
    """Whether it follows a stream of setpoints, many a second, once a motion was started."""

    @classmethod
    @abstractmethod
    def open(cls, cell: Cell, clock: Clock) -> Self:
        """Open the line to a cell's arm, and read its counts per angle. Nothing moves.

        Raises:
            ArmError: The line cannot be opened, or does not lead to this robot's controller.
            DataError: The robot has more joints than the controller moves.
            DependencyMissing: A package for it is not installed.
        """

    @abstractmethod
    def read(self) -> Array:
        """Read its joint values, at rest or in motion, (j,) [rad or m]. A disturbed line may corrupt one reading."""

    @abstractmethod
    def poll_faults(self) -> None:
        """Check whether a joint reports a fault.

        Raises:
            ArmAlarm: A joint does.
        """

    @abstractmethod
    def start_move(self, q: Array, seconds: float) -> None:
        """Start a motion to angles, (j,), that takes about so many seconds. Returns at once.

        Only one motion is active at a time: an arm whose line is cut comes to rest at its goal.
        """

    def follow(self, q: Array) -> None:
        """Send a setpoint to all joints, (j,), and return at once; see `follows`."""
        raise NotImplementedError  # of an arm that plans its motions itself, `arm_class` refuses setpoints

    def prepare(self, q: Array) -> None:  # noqa: B027 - most arms have nothing to prepare
        """Send the goal of the next motion, (j,), without starting it; the arm may still move."""

    @abstractmethod
    def stop(self) -> None:
        """Stop at the current position and discard the motion, at once. The caller checks that it is at rest.

        Raises:
            AnswerUnclear: An arm that can confirm this does not.
        """

    @abstractmethod
    def home(self) -> None:
        """Search the home position, and return when it is found.

        Raises:
            ArmError: It was not.
        """

    def switch(self, output: int, *, on: bool) -> None:
        """Switch a digital output, such as the laser's, on or off; see `outputs`.

        Raises:
            ArmError: Its controller has none.
        """
        raise ArmError("This arm cannot switch outputs. Take [laser] out of cell.toml.")

    @abstractmethod
    def close(self) -> None:
        """Close the line."""


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
            kinds = [*ARMS, *others]
            raise wrong(FILE, ("arm", "kind"), kind, f"one of {', '.join(kinds)}", kinds)
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
