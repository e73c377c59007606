"""An emulated cell that runs: its clock, its arm at the end of a line, and the camera that watches the arm."""

import select
import time
from collections.abc import Callable, Mapping, Sequence
from pathlib import Path
from typing import TYPE_CHECKING, final

import numpy as np

from robolaser.data.cell_config import Cell, load_cell
from robolaser.emulator.acl import Acl
from robolaser.emulator.controller import Blow, Controller
from robolaser.emulator.encoders import Encoders
from robolaser.emulator.faults import ARM, Fault, read_fault
from robolaser.emulator.faulty import Faulty
from robolaser.emulator.line import MOST_PENDING, Line, Socket, Terminal
from robolaser.emulator.lss import Lss
from robolaser.emulator.snapshot import Moment
from robolaser.errors import AxisMissing, ControllerUnknown, FaultSenseless

if TYPE_CHECKING:
    from robolaser.emulator.stream import Stream

TICK_S, BUSY_TICK_S = 0.01, 0.002
"""How long it listens before it looks after everything else, and while it has something to say."""
LOOKS_A_S, MOST_LOOKS = 50.0, 400
"""How often, on its own clock, the arm is looked at; how often at most after a long moment."""
BITS_A_BYTE = 10
"""Start, eight, stop."""
HOMELESS = "lss"
"""The kind whose servos search no home."""


def _acl(cell: Cell) -> Controller:
    return Acl(cell.robot, Encoders(cell.robot, cell.arm.reference_rad, cell.arm.direction))


def _lss(cell: Cell) -> Controller:
    return Lss(cell.robot, cell.arm.ids, cell.arm.reference_rad, cell.arm.direction)


CONTROLLERS: Mapping[str, Callable[[Cell], Controller]] = {"acl": _acl, "lss": _lss}


def controller_of(cell: Cell) -> Controller:
    """The controller that a cell's arm has.

    Raises:
        ControllerUnknown: No emulated controller speaks the arm's language.
    """
    if cell.arm.kind not in CONTROLLERS:
        raise ControllerUnknown(cell.arm.kind, CONTROLLERS)
    return CONTROLLERS[cell.arm.kind](cell)


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
        _check(wanted, cell.arm.kind, len(cell.robot.joints))
        self._line: Line = Socket() if over_socket else Terminal(cell.arm.baud, line)
        self._bytes_a_s = cell.arm.baud / BITS_A_BYTE
        self._hurry = hurry
        self._told_s = 0.0
        self._pending = b""
        self._laser = cell.laser_output
        self._watched_s = 0.0
        self.arm = self._line.address
        self._stream = None
        if world is not None:
            self._stream = _watching(
                world, cell, self._moment(0.0), wanted, np.random.default_rng([seed, 2]), camera_port
            )
        self.camera = None if self._stream is None else self._stream.address
        self._began = time.monotonic()

    def turn(self) -> None:
        """Listen for a moment, answer, and move on."""
        select.select(self._line.waits_on(), [], [], BUSY_TICK_S if self._pending else TICK_S)
        now_s = (time.monotonic() - self._began) * self._hurry
        if self._controller.cut(now_s):
            self._line.pull()
            time.sleep(TICK_S)
        if self._stream is not None:
            self._stream.tell(self._moment(now_s))
        said = self._controller.hear(self._line.take(), now_s) + self._controller.speak(now_s)
        self._pending = (self._pending + said)[:MOST_PENDING]
        self._tell(now_s)

    def close(self) -> None:
        """Let go of line and camera."""
        self._line.pull()
        if self._stream is not None:
            self._stream.close()

    def _moment(self, now_s: float) -> Moment:
        """How the arm went since it was last looked at, in steps so small that gears feel every turn."""
        steps = max(1, min(round((now_s - self._watched_s) * LOOKS_A_S), MOST_LOOKS))
        path = [self._controller.motor(float(t)) for t in np.linspace(self._watched_s, now_s, steps + 1)[1:]]
        self._watched_s = now_s
        lit = self._laser is None or self._laser in self._controller.outputs(now_s)
        return Moment(path, lit, now_s, self._controller.heard)

    def _tell(self, now_s: float) -> None:
        """Send what the line carries in the time since it last carried something."""
        fits = int((now_s - self._told_s) * self._bytes_a_s)
        if not self._pending or fits:
            self._told_s = now_s
        if self._pending and fits:
            self._pending = self._pending[self._line.give(self._pending[:fits]) :]


def _watching(
    world: Path, cell: Cell, begin: Moment, faults: Sequence[Fault], rng: np.random.Generator, port: int
) -> "Stream":
    from robolaser.emulator.stream import Stream  # noqa: PLC0415 - an arm without a camera must not pay for light
    from robolaser.emulator.world import load_world  # noqa: PLC0415

    return Stream(load_world(world, cell.description), begin, faults, rng, port)


def _check(faults: Sequence[Fault], kind: str, axes: int) -> None:
    for fault in faults:
        if kind == HOMELESS and fault.kind == Blow.HOMELESS.value:
            raise FaultSenseless(fault.kind, f"arms of kind '{kind}' search no home")
        if fault.kind in ARM and fault.amount > axes:
            raise AxisMissing(fault.kind, int(fault.amount), axes)
