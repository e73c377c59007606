"""An emulated cell that runs: its clock, its arm at the end of a line, and the camera that watches the arm."""

import select
import time
from collections.abc import Sequence
from pathlib import Path
from typing import final

import numpy as np

from robolaser.cell import Cell, load_cell
from robolaser.emulator.acl import Acl
from robolaser.emulator.controller import Controller
from robolaser.emulator.encoders import Encoders
from robolaser.emulator.faults import ARM, Fault, read_fault
from robolaser.emulator.faulty import Faulty
from robolaser.emulator.line import MOST_PENDING, Line, Socket, Terminal
from robolaser.errors import AxisMissing, ControllerUnknown, NoArmToEmulate

TICK_S, BUSY_TICK_S = 0.01, 0.002
"""How long it listens before it looks after everything else, and while it has something to say."""
BITS_A_BYTE = 10
"""Start, eight, stop."""
KINDS = ("acl",)


def controller_of(cell: Cell) -> Controller:
    """The controller that a cell's arm has.

    Raises:
        NoArmToEmulate: The cell has no robot.
        ControllerUnknown: No emulated controller speaks the arm's language.
    """
    robot, arm = cell.description.robot, cell.arm
    if robot is None:
        raise NoArmToEmulate(cell.description.folder or Path())
    if arm.kind == "acl":
        return Acl(robot, Encoders(robot, arm.reference_rad, arm.direction))
    raise ControllerUnknown(arm.kind, KINDS)


@final
class Running:
    """One emulated cell.

    Attributes:
        arm: Where the arm's line is.
        camera: Where the camera is; None: there is none.
    """

    def __init__(
        self,
        folder: Path,
        *,
        world: Path | None = None,
        hurry: float = 1.0,
        seed: int = 1,
        faults: Sequence[str] = (),
        camera_port: int = 0,
        over_socket: bool = False,
    ) -> None:
        cell = load_cell(folder)
        wire, line = np.random.default_rng([seed, 0]), np.random.default_rng([seed, 1])
        wanted = [read_fault(text) for text in faults]
        self._controller = Faulty(controller_of(cell), wanted, wire)
        _check(wanted, len(self._controller.motor(0.0)))
        self._line: Line = Socket() if over_socket else Terminal(cell.arm.baud, line)
        self._bytes_a_s = cell.arm.baud / BITS_A_BYTE
        self._hurry = hurry
        self._began = time.monotonic()
        self._told_s = 0.0
        self._pending = b""
        self.arm = self._line.address
        self.camera: str | None = None

    def turn(self) -> None:
        """Listen for a moment, answer, and move on."""
        select.select(self._line.waits_on(), [], [], BUSY_TICK_S if self._pending else TICK_S)
        now_s = (time.monotonic() - self._began) * self._hurry
        if self._controller.cut(now_s):
            self._line.pull()
            time.sleep(TICK_S)
        said = self._controller.hear(self._line.take(), now_s) + self._controller.speak(now_s)
        self._pending = (self._pending + said)[:MOST_PENDING]
        self._tell(now_s)

    def close(self) -> None:
        """Let go of line and camera."""
        self._line.pull()

    def _tell(self, now_s: float) -> None:
        """Send what the line carries in the time since it last carried something."""
        fits = int((now_s - self._told_s) * self._bytes_a_s)
        if not self._pending or fits:
            self._told_s = now_s
        if self._pending and fits:
            self._pending = self._pending[self._line.give(self._pending[:fits]) :]


def _check(faults: Sequence[Fault], axes: int) -> None:
    for fault in faults:
        if fault.kind in ARM and fault.amount > axes:
            raise AxisMissing(fault.kind, int(fault.amount), axes)
