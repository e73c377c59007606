"""A running emulated cell: its clock, its arm on a line, and its camera.

The camera is a server that renders images continuously for its clients.
"""

import json
import os
import select
import signal
import socket
import socketserver
import stat
import threading
import time
import tty
from collections.abc import Iterable, Sequence
from contextlib import suppress
from pathlib import Path
from typing import final

import cv2
import numpy as np

from robolaser.arrays import Array
from robolaser.data.cell_config import FILE, Cell, load_cell
from robolaser.data.toml_schema import wrong
from robolaser.emulator.acl import AclController
from robolaser.emulator.bus_servos import BusServos
from robolaser.emulator.controller import ArmFault, Controller
from robolaser.emulator.faults import ARM, Fault, FaultyController, not_a_fault, read_fault
from robolaser.emulator.lss import LssController
from robolaser.emulator.servo_loop import SERVO_FAULTS, ServoLoop
from robolaser.emulator.world.world import EmulatedWorld, load_world
from robolaser.errors import DataError, UsageError

FRAMES_A_S = 15.0
BUFFER_BYTES = 65536  # send buffer for a slow client: a fraction of a frame


@final
class CameraServer:
    """A camera in a world. A client's next frame is rendered when the last one is sent: a slow one misses some."""

    def __init__(self, world: EmulatedWorld, rng: np.random.Generator) -> None:
        self._world, self._rng, self._lit = world, rng, False
        self._drawing = threading.Lock()
        self._broken: Exception | None = None
        self._ended = False
        frames_to = self._send_frames

        class Client(socketserver.BaseRequestHandler):
            def handle(self) -> None:
                frames_to(self.request)

        self._server = socketserver.ThreadingTCPServer(("127.0.0.1", 0), Client)
        self._server.daemon_threads = True
        self.address = f"tcp://127.0.0.1:{self._server.server_address[1]}"
        self._thread = threading.Thread(target=self._server.serve_forever, args=(0.05,), daemon=True)
        self._thread.start()

    def follow(self, path: Iterable[Array], *, lit: bool) -> None:
        """Update the world by readings of the encoders, (j,) each [rad], and by the laser's state after them.

        Raises:
            Exception: Any error of rendering.
        """
        if self._broken is not None:
            raise self._broken
        for motor in path:
            self._world.follow(motor)
        self._lit = lit

    def close(self) -> None:
        """Stop, and disconnect all clients."""
        self._ended = True
        self._server.shutdown()
        self._thread.join()
        self._server.server_close()

    def _send_frames(self, client: socket.socket) -> None:
        client.setsockopt(socket.SOL_SOCKET, socket.SO_SNDBUF, BUFFER_BYTES)
        with suppress(OSError):  # the client left
            while not self._ended:
                began = time.monotonic()
                try:
                    frame = self._drawn()
                except Exception as error:  # `follow` raises it
                    self._broken = error
                    return
                client.sendall(frame)
                time.sleep(max(0.0, began + 1 / FRAMES_A_S - time.monotonic()))

    def _drawn(self) -> bytes:
        with self._drawing:
            image = self._world.photograph(self._rng, lit=self._lit)
        return cv2.imencode(".pgm", image)[1].tobytes()


TICK_S, BUSY_TICK_S = 0.01, 0.002  # longest wait for input, and that while output is pending
LOOKS_A_S, MOST_LOOKS = 50.0, 400  # samples of the arm per second of its clock; most samples in one `turn`
BITS_A_BYTE = 10  # start, eight, stop
LARGEST_READ = 4096
MOST_PENDING = 65536  # bytes kept for a client that does not read; more are lost, as without flow control
CONTROLLERS = ("acl", "dynamixel", "feetech", "lss")  # kinds of arms that are emulated


def controller_of(cell: Cell, loop: ServoLoop | None = None) -> Controller:
    """The controller of a cell's arm, with the servo loop of the world; without one, joints follow exactly.

    Raises:
        DataError: No emulated controller has the arm's protocol, or a loop is given and it has none.
    """
    if cell.arm.kind not in CONTROLLERS:
        expected = f"one that is emulated: {', '.join(CONTROLLERS)}"
        raise wrong(FILE, ("arm", "kind"), cell.arm.kind, expected, CONTROLLERS)
    if cell.arm.kind in ("dynamixel", "feetech"):
        return BusServos(cell, loop)
    if loop is not None:
        raise DataError(
            f"The world has effects of servos ({', '.join(SERVO_FAULTS)}), but arms of kind '{cell.arm.kind}' are"
            " emulated without them. Take these [[effect]] out.",
            column="effect",
        )
    return LssController(cell) if cell.arm.kind == "lss" else AclController(cell)


@final
class ServedLine:
    """Non-blocking input and output of bytes."""

    def __init__(self) -> None:
        near, self._far = os.openpty()
        self._near: int | None = near
        tty.setraw(self._far)
        os.set_blocking(near, False)
        self.address = os.ttyname(self._far)  # for pyserial

    def waits_on(self) -> list[int]:
        """Descriptors that become readable with new data."""
        return [] if self._near is None else [self._near]

    def take(self) -> bytes:
        """Return new data."""
        if self._near is None:
            return b""
        try:
            return os.read(self._near, LARGEST_READ)
        except BlockingIOError:
            return b""

    def give(self, data: bytes) -> int:
        """Send as much as fits now; return the number of bytes. After a disconnection all are lost."""
        if self._near is None:
            return len(data)
        try:
            return os.write(self._near, data)
        except BlockingIOError:
            return 0

    def hang_up(self) -> None:
        """Disconnect the line."""
        if self._near is not None:
            os.close(self._near)
            os.close(self._far)
            self._near = None


@final
class EmulatedCell:
    """One emulated cell, with the addresses of the arm's line and of the camera; None: there is no camera."""

    def __init__(
        self,
        folder: Path,
        *,
        world: Path | None = None,
        time_scale: float = 1.0,
        seed: int = 1,
        faults: Sequence[str] = (),
    ) -> None:
        cell = load_cell(folder)
        wire = np.random.default_rng([seed, 0])
        wanted = [read_fault(text) for text in faults]
        seen = None if world is None else load_world(world, cell.description)
        self._controller = FaultyController(controller_of(cell, seen and seen.loop), wanted, wire)
        _check(wanted, cell.arm.kind, len(cell.robot.joints))
        self._line = ServedLine()
        self._bytes_a_s = cell.arm.baud / BITS_A_BYTE
        self._time_scale = time_scale
        self._sent_s = 0.0
        self._pending = b""
        self._laser = cell.laser_output
        self._watched_s = 0.0
        self.arm = self._line.address
        self._stream: CameraServer | None = None
        if seen is not None:
            self._stream = CameraServer(seen, np.random.default_rng([seed, 2]))
            self._watch(0.0, self._stream)
        self.camera = None if self._stream is None else self._stream.address
        self._began = time.monotonic()

    def turn(self) -> None:
        """Listen briefly, answer, and advance the clock."""
        select.select(self._line.waits_on(), [], [], BUSY_TICK_S if self._pending else TICK_S)
        now_s = (time.monotonic() - self._began) * self._time_scale
        if self._controller.cut(now_s):
            self._line.hang_up()
            time.sleep(TICK_S)
        if self._stream is not None:
            self._watch(now_s, self._stream)
        if not self._pending:
            self._sent_s = now_s
        answer = self._controller.receive(self._line.take(), now_s) + self._controller.poll(now_s)
        self._pending = (self._pending + answer)[:MOST_PENDING]
        self._transmit(now_s)

    def close(self) -> None:
        """Close line and camera."""
        self._line.hang_up()
        if self._stream is not None:
            self._stream.close()

    def _watch(self, now_s: float, camera: CameraServer) -> None:
        """Pass the arm's path since the last call to the camera, in steps that show every reversal."""
        steps = max(1, min(round((now_s - self._watched_s) * LOOKS_A_S), MOST_LOOKS))
        path = (self._controller.motor(float(t)) for t in np.linspace(self._watched_s, now_s, steps + 1)[1:])
        lit = self._laser is None or self._laser in self._controller.outputs(now_s)
        camera.follow(path, lit=lit)
        self._watched_s = now_s

    def _transmit(self, now_s: float) -> None:
        """Send as many bytes as the line carries in the time since the last ones."""
        fits = int((now_s - self._sent_s) * self._bytes_a_s)
        if self._pending and fits:
            self._sent_s = now_s
            self._pending = self._pending[self._line.give(self._pending[:fits]) :]


def _check(faults: Sequence[Fault], kind: str, axes: int) -> None:
    for fault in faults:
        if kind != "acl" and fault.kind == ArmFault.HOMELESS.value:
            raise not_a_fault(fault.kind, f"arms of kind '{kind}' do no homing")
        if fault.kind in ARM and fault.amount > axes:
            raise UsageError(f"--fault {fault.kind}:{int(fault.amount)}: the arm has axes 1 to {axes}.")


def serve(cell: EmulatedCell) -> None:
    """Print the addresses of arm and camera, and serve until killed, or until the pipe at standard input closes."""
    ended: list[int] = []
    for number in (signal.SIGTERM, signal.SIGINT):
        signal.signal(number, lambda which, frame: ended.append(which))
    print(json.dumps({"arm": cell.arm, "camera": cell.camera}), flush=True)
    try:
        while not ended and not _hung_up():
            cell.turn()
    finally:
        cell.close()


def _hung_up() -> bool:
    """Whether standard input is a pipe whose other end is closed."""
    try:
        if not stat.S_ISFIFO(os.fstat(0).st_mode):
            return False
        return bool(select.select([0], [], [], 0)[0]) and not os.read(0, 1024)
    except OSError:
        return False
