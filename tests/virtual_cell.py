"""A cell in virtual time: an emulated controller on a fake wire, a camera in its world, and a virtual clock."""

from collections.abc import Callable, Iterator, Sequence
from contextlib import contextmanager
from pathlib import Path

import numpy as np
import pytest

from robolaser.arrays import Array, Image
from robolaser.cell.serial_line import TICK_S, SerialLine
from robolaser.data.cell_config import load_cell
from robolaser.emulator.controller import Controller
from robolaser.emulator.emulated_cell import controller_of
from robolaser.emulator.faults import FaultyController, read_fault
from robolaser.emulator.world.world import EmulatedWorld, load_world

BITS_A_BYTE = 10
BAUD = 9600
EXPOSURE_S = 0.1
LOOK_S = 0.02
"""Interval between motor updates, so that gears see every reversal."""


class Jumping:
    """A clock that only advances by waiting."""

    def __init__(self) -> None:
        self.time_s = 0.0
        self.at: list[tuple[float, Callable[[], None]]] = []

    def now(self) -> float:
        return self.time_s

    def wait(self, seconds: float) -> None:
        self.time_s += seconds
        due = [event for event in self.at if event[0] <= self.time_s]
        self.at = [event for event in self.at if event[0] > self.time_s]
        for _, event in due:
            event()


class Bench:
    """A wire to an emulated controller, in place of a pyserial port."""

    def __init__(
        self, controller: Controller, clock: Jumping, faults: Sequence[str] = (), seed: int = 1, baud: int = BAUD
    ) -> None:
        self.clock = clock
        self._bytes_a_s = baud / BITS_A_BYTE
        self.controller = FaultyController(
            controller, [read_fault(text) for text in faults], np.random.default_rng(seed)
        )
        self.coming = b""
        self.sent = b""

    def motor(self) -> Array:
        return self.controller.motor(self.clock.now())

    def _listen(self) -> None:
        self.coming += self.controller.poll(self.clock.now())
        if self.controller.cut(self.clock.now()):
            raise OSError("device disconnected")

    @property
    def in_waiting(self) -> int:
        self._listen()
        return len(self.coming)

    def read(self, size: int) -> bytes:
        self._listen()
        if not self.coming:
            self.clock.wait(TICK_S)
            self._listen()
        data, self.coming = self.coming[:size], self.coming[size:]
        self.clock.wait(len(data) / self._bytes_a_s)
        return data

    def write(self, data: bytes) -> int:
        self._listen()
        self.sent += data
        self.clock.wait(len(data) / self._bytes_a_s)
        self.coming += self.controller.receive(data, self.clock.now())
        return len(data)

    def close(self) -> None:
        """Nothing."""


class Witness:
    """A camera in a world whose arm follows the motors on a bench."""

    def __init__(self, bench: Bench, world: EmulatedWorld, laser: int | None, seed: int) -> None:
        self._bench, self._world, self._laser = bench, world, laser
        self._rng = np.random.default_rng(seed)
        self._look()

    def shot(self, settle_s: float) -> Image:
        clock = self._bench.clock
        clock.wait(settle_s + EXPOSURE_S)
        self._world.follow(self._bench.motor())
        lit = self._laser is None or self._laser in self._bench.controller.outputs(clock.now())
        return self._world.photograph(self._rng, lit=lit)

    def close(self) -> None:
        """Nothing."""

    def _look(self) -> None:
        clock = self._bench.clock
        self._world.follow(self._bench.motor())
        clock.at.append((clock.now() + LOOK_S, self._look))


@contextmanager
def in_virtual_time(folder: Path, *, faults: Sequence[str] = (), seed: int = 1) -> Iterator[None]:
    """Connect every port of `robolaser record` to a cell's emulated controller, without real waiting.

    The camera shows the cell's world, if the cell has a world.toml.
    """
    cell = load_cell(folder)
    file = folder / "world.toml"
    world = load_world(file, cell.description) if file.is_file() else None
    clock = Jumping()
    bench = Bench(controller_of(cell, world and world.loop), clock, faults, seed, cell.arm.baud)
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr("robolaser.cell.clock.Clock", lambda: clock)
        patch.setattr(SerialLine, "open", lambda arm, clock: SerialLine(bench, arm.port, clock))
        if world is not None:
            witness = Witness(bench, world, cell.laser_output, seed)
            patch.setattr("robolaser.cell.camera.open_camera", lambda *_: witness)
        yield
