"""The emulated camera: a live stream that OpenCV opens, of the world as it stands."""

import socket
import time
from collections.abc import Callable, Iterator
from pathlib import Path

import cv2
import numpy as np
import pytest
import serial
from emulated_cell import cell_folder, world_file
from emulator_process import EmulatorProcess

from robolaser.emulator.emulated_cell import FRAMES_A_S, CameraServer


def ask(port: serial.SerialBase, line: str) -> str:
    port.write(line.encode() + b"\r")
    return port.read_until(b">").decode(errors="replace")


def test_the_camera_sees_the_board_the_laser_and_that_the_arm_moved(tmp_path: Path) -> None:
    folder = cell_folder(tmp_path)
    with (
        EmulatorProcess(folder, world=world_file(folder), time_scale=20) as emulated,
        serial.serial_for_url(emulated.arm, 9600, timeout=30) as port,
    ):
        camera = cv2.VideoCapture(emulated.camera, cv2.CAP_FFMPEG)
        try:
            dark = settled(camera)
            assert dark.shape == (480, 640)
            assert cv2.findChessboardCorners(dark, (9, 7))[0]
            assert dark.max() < 200
            ask(port, "SET OUT[1]=1")
            lit = seen(camera, lambda frame: frame.max() == 255)
            still = np.abs(settled(camera).astype(float) - lit).mean()
            assert still > 0
            for line in ("DEFP P", "HERE P", "SETPV P 1 1000", "MOVE P 100"):
                ask(port, line)
            seen(camera, lambda frame: np.abs(frame.astype(float) - lit).mean() > 5 * still)
        finally:
            camera.release()


def seen(camera: cv2.VideoCapture, shows: Callable[[np.ndarray], bool]) -> np.ndarray:
    """The first frame that shows something, however late a busy machine delivers it."""
    until = time.monotonic() + 30.0
    while not shows(frame := settled(camera)):
        assert time.monotonic() < until, "no frame shows it"
    return frame


def settled(camera: cv2.VideoCapture) -> np.ndarray:
    """A frame that is half a second younger than the last one."""
    until = time.monotonic() + 0.5
    while True:
        ok, frame = camera.read()
        assert ok
        if time.monotonic() > until:
            return cv2.cvtColor(frame, cv2.COLOR_BGR2GRAY)


SHAPE = (480, 640)
LIT = 100
"""How much brighter it is while the laser is on."""
HEADER = len(b"P5\n640 480\n255\n")
FRAME = HEADER + SHAPE[0] * SHAPE[1]
LATE_S = 30.0
"""On a busy machine all comes, if late."""


class Numbered:
    """A world that draws its number of pictures as grey, and remembers where the arm went."""

    def __init__(self) -> None:
        self.went: list[float] = []
        self.drawn = 0

    def follow(self, motor: np.ndarray) -> None:
        self.went.append(float(motor[0]))

    def photograph(self, rng: np.random.Generator, *, lit: bool) -> np.ndarray:
        self.drawn += 1
        return np.full(SHAPE, self.drawn + (LIT if lit else 0), np.uint8)


@pytest.fixture
def world() -> Numbered:
    return Numbered()


@pytest.fixture
def stream(world: Numbered) -> Iterator[CameraServer]:
    made = CameraServer(world, np.random.default_rng(1))
    yield made
    made.close()


def watch(stream: CameraServer) -> socket.socket:
    host, port = stream.address.removeprefix("tcp://").split(":")
    return socket.create_connection((host, int(port)), timeout=LATE_S)


def wait_for(there: Callable[[], object]) -> None:
    until = time.monotonic() + LATE_S
    while not there():
        assert time.monotonic() < until, "it never came"
        time.sleep(0.01)


def grey(client: socket.socket) -> int:
    frame = b""
    while len(frame) < FRAME:
        frame += client.recv(FRAME - len(frame))
    return frame[-1]


def test_the_world_follows_every_turn_though_no_one_watches(stream: CameraServer, world: Numbered) -> None:
    path = [0.1, 0.2, 0.3, 0.2, 0.1, 0.0, 0.1]
    for angle in path:
        stream.follow([np.array([angle]), np.array([angle + 0.05])], lit=False)
    assert world.went == [angle for first in path for angle in (first, first + 0.05)]
    assert not world.drawn


def test_frames_come_one_after_the_other(stream: CameraServer) -> None:
    with watch(stream) as client:
        seen = [grey(client) for _ in range(5)]
    assert np.all(np.diff(seen) >= 1)


def test_a_slow_client_misses_frames_and_soon_sees_the_present(stream: CameraServer) -> None:
    with watch(stream) as client:
        assert grey(client) < LIT
        time.sleep(18 / FRAMES_A_S)
        stream.follow([], lit=True)
        waiting = [grey(client)]
        while waiting[-1] < LIT:
            waiting.append(grey(client))
    assert len(waiting) <= 12


def test_several_clients_watch_at_once(stream: CameraServer) -> None:
    with watch(stream) as one, watch(stream) as other:
        assert grey(one) > 0
        assert grey(other) > 0


def test_what_breaks_while_it_draws_is_heard(stream: CameraServer, world: Numbered) -> None:
    def breaks(rng: np.random.Generator, *, lit: bool) -> np.ndarray:
        raise ZeroDivisionError

    world.photograph = breaks
    with watch(stream):
        wait_for(lambda: stream._broken)
    with pytest.raises(ZeroDivisionError):
        stream.follow([], lit=False)
