"""Cameras that run by themselves, and piles of pictures that pass for one."""

import socket
import threading
import time
from collections.abc import Callable, Iterator, Sequence
from contextlib import closing, contextmanager, suppress
from dataclasses import replace
from itertools import pairwise
from typing import Any

import bench
import cv2
import numpy as np
import pytest

from robolaser.arrays import Image
from robolaser.cell import camera as camera_module
from robolaser.cell.camera import Camera, LiveCamera, open_camera
from robolaser.cell.clock import Clock
from robolaser.data.cell_config import CameraLine
from robolaser.errors import CameraError

SIZE = (24, 16)
FRAME_S = 0.005
STREAMED_S = 0.05
"""A busy reader keeps up: what it has not read yet shows the past."""
OPENING, OPENED_S = 150, 0.002
"""Images that FFmpeg looks at before it says what a stream is, 5 s of them at 25 a second; these come faster."""
PATIENCE_S = 60.0
"""A test that waits for so long fails: what must be noticed earlier has another reason than silence."""


class Capture:
    """What OpenCV opens, as far as it is used."""

    def __init__(self, frame: Callable[[int], Image | None], allows: bool = True) -> None:
        self._frame = frame
        self._allows = allows
        self.number = 0
        self.released = False

    def isOpened(self) -> bool:  # noqa: N802 - OpenCV's
        return True

    def set(self, what: int, value: float) -> bool:
        return self._allows

    def read(self) -> tuple[bool, Image | None]:
        time.sleep(FRAME_S)
        self.number += 1
        frame = self._frame(self.number)
        return frame is not None, frame

    def release(self) -> None:
        self.released = True


def noisy(number: int, low: int = 50, size: tuple[int, int] = SIZE) -> Image:
    return np.random.default_rng(number).integers(low, low + 6, size[::-1], dtype=np.uint8)


class Hurried:
    """A clock by which a camera stays the same for long within a blink."""

    def now(self) -> float:
        return 1e4 * time.monotonic()

    def wait(self, seconds: float) -> None:
        time.sleep(seconds)


@pytest.fixture(autouse=True)
def patient(monkeypatch: pytest.MonkeyPatch) -> None:
    """However late a busy machine delivers an image, no camera is lost for it."""
    monkeypatch.setattr(camera_module, "SILENT_S", PATIENCE_S)
    monkeypatch.setattr(camera_module, "FIRST_S", PATIENCE_S)


@pytest.fixture
def running(monkeypatch: pytest.MonkeyPatch) -> Iterator[Callable[..., LiveCamera]]:
    """Opens a camera that gives the frames it is told to."""
    opened: list[LiveCamera] = []

    def open_one(frame: Callable[[int], Image | None], said: list[str] | None = None, **more: Any) -> LiveCamera:
        capture = Capture(frame, more.pop("allows", True))
        monkeypatch.setattr(cv2, "VideoCapture", lambda *_: capture)
        clock = more.pop("clock", Clock())
        camera = LiveCamera(CameraLine(0, **more), SIZE, clock, [].append if said is None else said.append)
        opened.append(camera)
        return camera

    yield open_one
    for camera in opened:
        camera.close()


def test_a_shot_shows_what_is_there_after_the_settling(running):
    scene = [50]
    camera = running(lambda number: noisy(number, scene[0]))
    for level in (120, 60, 200):
        scene[0] = level
        assert camera.shot(0.03).min() >= level


@pytest.mark.parametrize("times", [1, 2])
def test_shots_in_a_row_are_different_images_though_each_comes_twice(running, times):
    camera = running(lambda number: noisy(number // times))
    shots = [camera.shot(0.0) for _ in range(5)]
    assert not any(np.array_equal(a, b) for a, b in pairwise(shots))


def test_colours_become_grey_and_other_numbers_are_none(running):
    colour = running(lambda number: np.repeat(noisy(number)[:, :, None], 3, axis=2))
    assert colour.shot(0.0).shape == SIZE[::-1]
    with pytest.raises(CameraError, match="uint16, expected integers of 8 bits"):
        running(lambda number: noisy(number).astype(np.uint16) << 8)


def test_a_camera_that_sends_nothing_is_lost(running, monkeypatch):
    silent, over = threading.Event(), threading.Event()

    def stops(number: int) -> Image:
        if number > 5:
            silent.set()
            over.wait()
        return noisy(number)

    camera = running(stops)
    silent.wait()
    monkeypatch.setattr(camera_module, "SILENT_S", 0.1)
    with pytest.raises(CameraError, match="none came"):
        camera.shot(0.0)
    over.set()


def broken(number: int) -> Image:
    raise ValueError("bad packet")


@pytest.mark.parametrize(
    ("then", "said"),
    [
        (lambda number: None, "unplugged"),
        (broken, "bad packet"),
        (lambda number: noisy(1), "to the last pixel"),
        (lambda number: noisy(number, size=(12, 8)), "12 x 8 pixels"),
        (lambda number: noisy(number, 250), "overexposed"),
    ],
)
def test_a_camera_that_is_of_no_use_any_more_is_noticed_at_once(running, then, said):
    sound = [True]
    camera = running(lambda number: noisy(number) if sound[0] else then(number), clock=Hurried())
    sound[0], began = False, time.monotonic()
    with pytest.raises(CameraError, match=said):
        camera.shot(0.1)
    assert time.monotonic() - began < PATIENCE_S


def test_a_camera_that_never_begins_is_lost(running):
    with pytest.raises(CameraError, match="no more images"):
        running(lambda number: None)


def test_whitish_images_are_pointed_out(running):
    said: list[str] = []

    def whitish(number: int) -> Image:
        image = noisy(number)
        image[:4] = 255
        return image

    running(whitish, said).shot(0.0)
    assert "shorter exposure" in said[0]


def test_a_covered_lens_is_pointed_out(running):
    said: list[str] = []
    running(lambda number: noisy(number, 0), said).shot(0.0)
    assert "covered" in said[0]


def test_a_black_or_a_white_image_that_never_changes_is_no_frozen_camera(running):
    said: list[str] = []
    assert not running(lambda number: np.zeros(SIZE[::-1], np.uint8), said, clock=Hurried()).shot(0.01).any()
    assert "covered" in said[0]
    with pytest.raises(CameraError, match="overexposed"):
        running(lambda number: np.full(SIZE[::-1], 255, np.uint8), clock=Hurried()).shot(0.01)
    with pytest.raises(CameraError, match="frozen"):
        running(lambda number: np.full(SIZE[::-1], 128, np.uint8), clock=Hurried()).shot(0.01)


def test_a_driver_that_refuses_an_exposure_is_pointed_out(running):
    said: list[str] = []
    running(noisy, said, exposure=-5.0, gain=2.0, allows=False)
    assert ["refuses exposure = -5" in said[0], "refuses gain = 2" in said[1]] == [True, True]


def test_a_camera_that_is_not_there_is_named(tmp_path):
    absent = replace(bench.cell(tmp_path), camera=CameraLine("/dev/video77"))
    with pytest.raises(CameraError, match="/dev/video77"):
        open_camera(absent, Clock(), print)


@contextmanager
def streamed(scene: Sequence[Any], ending: str = ".pgm") -> Iterator[tuple[str, list[Image]]]:
    """Sends images of a level and a size to whoever connects; gives the address and, last, the newest image."""
    sent: list[Image] = []
    server, over = socket.create_server(("127.0.0.1", 0)), threading.Event()
    server.settimeout(0.1)

    def send() -> None:
        number = 0
        while not over.is_set():
            with suppress(OSError):  # nobody came, or somebody left
                client, _ = server.accept()
                with client:
                    client.settimeout(1.0)
                    while not over.is_set():
                        number += 1
                        sent.append(noisy(number, *scene))
                        client.sendall(cv2.imencode(ending, sent[-1])[1].tobytes())
                        time.sleep(OPENED_S if number < OPENING else STREAMED_S)

    sender = threading.Thread(target=send)
    sender.start()
    try:
        yield f"tcp://127.0.0.1:{server.getsockname()[1]}", sent
    finally:
        over.set()
        sender.join()
        server.close()


def catch_up(camera: Camera, sent: list[Image]) -> None:
    """What came while the stream was opened, which takes seconds, is read first; decoders hold the last one back."""
    until = time.monotonic() + PATIENCE_S
    shot = camera.shot(0.0)
    while not any(np.array_equal(shot, image) for image in sent[-4:]):
        assert time.monotonic() < until, "the reader does not keep up"
        shot = camera.shot(0.0)


@pytest.mark.parametrize("ending", [".pgm", ".png"])
def test_a_stream_of_images_is_a_camera(tmp_path, ending):
    cell, scene = bench.cell(tmp_path), [50]
    with (
        streamed(scene, ending) as (address, sent),
        closing(open_camera(replace(cell, camera=CameraLine(address)), Clock(), print)) as camera,
    ):
        catch_up(camera, sent)
        scene[0] = 150
        shot = camera.shot(0.2)
    assert shot.min() >= 150
    assert shot.max() < 156


def test_a_stream_that_changes_its_size_is_noticed(tmp_path):
    cell, scene = bench.cell(tmp_path), [50, SIZE]
    with (
        streamed(scene) as (address, sent),
        closing(open_camera(replace(cell, camera=CameraLine(address)), Clock(), print)) as camera,
    ):
        catch_up(camera, sent)
        scene[1] = (48, 32)
        with pytest.raises(CameraError, match="48 x 32"):
            camera.shot(0.2)


@pytest.mark.parametrize("source", ["file:///etc/hostname", "concat://a|b", "TEE://x", "subfile://y"])
def test_streams_that_read_other_files_are_refused(tmp_path, source):
    with pytest.raises(CameraError, match="is not allowed"):
        open_camera(replace(bench.cell(tmp_path), camera=CameraLine(source)), Clock(), print)


def test_images_of_a_folder_come_one_by_one(cell, tmp_path):
    (tmp_path / "shots").mkdir()
    for i in range(3):
        cv2.imwrite(str(tmp_path / "shots" / f"s{i}.png"), np.full(SIZE[::-1], 60 + i, np.uint8))
    with closing(open_camera(replace(cell, camera=CameraLine(str(tmp_path / "shots"))), Clock(), print)) as camera:
        assert [int(camera.shot(0.0)[0, 0]) for _ in range(3)] == [60, 61, 62]
        with pytest.raises(CameraError, match="all its images"):
            camera.shot(0.0)


@pytest.mark.parametrize("source", ["nowhere.avi", "empty"])
def test_files_that_are_no_images_are_named(cell, tmp_path, source):
    (tmp_path / "empty").mkdir()
    with pytest.raises(CameraError, match=source):
        open_camera(replace(cell, camera=CameraLine(str(tmp_path / source))), Clock(), print)
