"""The emulated camera: a live stream that OpenCV opens, of the world as it stands."""

import time
from collections.abc import Callable
from pathlib import Path

import cv2
import numpy as np
import serial
from emulated_cell import cell_folder, world_file
from emulator_process import EmulatorProcess


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
