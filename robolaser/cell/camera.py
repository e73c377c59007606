"""The camera of a cell: a live camera, or a folder of images in its place."""

import threading
from collections.abc import Callable
from pathlib import Path
from typing import Any, final

import cv2
import numpy as np

from robolaser.arrays import Image
from robolaser.bounded_reading import decoded
from robolaser.cell.clock import Clock
from robolaser.data.cell_config import CameraLine, Cell
from robolaser.data.image_list import images_of_poses
from robolaser.data.loading import load
from robolaser.errors import CameraError, RobolaserError
from robolaser.vision.images import CameraImages

Warn = Callable[[str], None]

STREAMS = ("tcp", "udp", "rtp", "rtsp", "rtsps", "http", "https")
"""Allowed URL schemes: FFmpeg has many more, which read other files or write."""
ENDINGS = (".png", ".pgm", ".jpg", ".jpeg", ".bmp", ".tif", ".tiff")
WHITE = 250  # least grey value of a saturated pixel
MOSTLY = 0.5  # share of white pixels from which an image is useless,
MUCH = 0.1  # and that a stripe alone never reaches
DARK = 12  # grey value that some pixel exceeds unless the image is dark
SILENT_S = 2.0  # a camera that sends no image for so long is lost
FIRST_S = 8.0  # the first image may take longer: streams are analysed, exposures adjusted
MANUAL = 1.0  # manual exposure in most drivers (V4L2)
PASSED_ON = 2  # buffered images that may have been exposed before the request
OPENING_MS = 8000  # of a stream,
READING_MS = 2000  # and of its next image
RAW = -1.0  # format for undecoded images: OpenCV's decoding hides a change of size


def open_camera(cell: Cell, clock: Clock, warn: Warn) -> "Camera":
    """Open a cell's camera: a number, a device (/dev/...) or a stream (with ://) runs by itself, all else is a folder.

    Raises:
        CameraError: It is not there, sends nothing, or the cell takes no images.
        RobolaserError: A recording in its place, or an image, cannot be read.
    """
    source, size = cell.camera.source, cell.description.image_px
    if size is None:
        raise cannot_open(source, "dataset.toml has no [image] that states the size of its images")
    scheme, separator, _ = str(source).partition("://")
    if separator and scheme.lower() not in STREAMS:
        raise cannot_open(source, f"{scheme}:// is not allowed, only {', '.join(STREAMS)}")
    if cell.pictures is not None:
        return RecordedImages(cell.pictures, size, warn)
    return LiveCamera(cell.camera, size, clock, warn)


@final
class LiveCamera:
    """Grey images of one size, (h, w) uint8, of a device or a stream.

    A thread reads it and keeps the newest image only.
    """

    def __init__(self, line: CameraLine, size: tuple[int, int], clock: Clock, warn: Warn) -> None:
        self._source = line.source
        self._size = size
        self._clock = clock
        self._warn = warn
        self._capture, self._single = _opened(line, size, warn)
        self._news = threading.Condition()
        self._closing = False
        self._image: Image | None = None
        self._count = 0
        self._same = 0
        self._same_s = 0.0
        self._end: RobolaserError | None = None
        self._reader = threading.Thread(target=self._read, name=f"camera {line.source}", daemon=True)
        self._reader.start()
        try:
            self._wait_for(self._count + 1, FIRST_S)
        except BaseException:
            self.close()
            raise

    def shot(self, settle_s: float) -> Image:
        """Return an image that is exposed from now on, or after a wait [s] where something changed.

        Raises:
            CameraError: No image comes, all are the same, or the image is useless.
        """
        self._clock.wait(settle_s)
        with self._news:
            wanted = self._count + 1 + (PASSED_ON if settle_s else 0)
        image = self._wait_for(wanted, SILENT_S)
        _check(self._source, image, self._size, self._warn)
        return image

    def close(self) -> None:
        """Close it."""
        self._closing = True
        self._reader.join(SILENT_S)
        if not self._reader.is_alive():  # a blocked driver is left alone
            self._capture.release()

    def _wait_for(self, number: int, patience_s: float) -> Image:
        """The first image from a number on that differs from the one before it, or is black or white all over."""
        with self._news:
            while self._image is None or self._count < number or (self._same and not _cut_off(self._image)):
                if self._end is not None:
                    raise self._end
                if not self._news.wait(patience_s):  # every image wakes it, and the end
                    raise no_more_images(self._source, f"none came for {patience_s:.0f} s")
                cut_off = self._image is not None and _cut_off(self._image)
                if self._same and not cut_off and self._clock.now() - self._same_s > SILENT_S:
                    raise CameraError(
                        f"Camera {self._source} is frozen: {self._same + 1} images in"
                        f" {self._clock.now() - self._same_s:.1f} s were the same to the last pixel, which"
                        " no live camera does. Unplug it and plug it in again."
                    )
            return self._image

    def _read(self) -> None:
        """Keep the newest image until there is no more."""
        end: RobolaserError | None = None
        while not self._closing and end is None:
            try:
                there, frame = self._capture.read()
                image = self._grey(frame) if there else None
                end = None if there else no_more_images(self._source, "it has ended or was unplugged")
            except RobolaserError as error:
                image, end = None, error
            except Exception as error:  # any error of a driver is raised in the waiting thread
                image, end = None, no_more_images(self._source, str(error))
            if image is None and end is None:
                continue
            with self._news:
                self._end = end
                if image is not None:
                    self._keep(image)
                self._news.notify_all()

    def _keep(self, image: Image) -> None:
        if self._image is not None and np.array_equal(image, self._image):
            self._same += 1
        else:
            self._same, self._same_s = 0, self._clock.now()
        self._image, self._count = image, self._count + 1

    def _grey(self, frame: Any) -> Image | None:
        """A decoded image, (h, w) or (h, w, 3), or an encoded one, as (h, w) uint8; None if it is incomplete."""
        if self._single:
            image: Image | None = decoded(frame.tobytes(), cv2.IMREAD_GRAYSCALE)
            return image
        if frame.dtype != np.uint8:
            raise cannot_open(self._source, f"its images hold {frame.dtype}, expected integers of 8 bits")
        return np.asarray(frame if frame.ndim == 2 else cv2.cvtColor(frame, cv2.COLOR_BGR2GRAY), dtype=np.uint8)


@final
class RecordedImages:
    """A folder in place of a camera: each shot is the next image, of a recording as they were taken, else by name."""

    def __init__(self, folder: Path, size: tuple[int, int], warn: Warn) -> None:
        self._folder, self._size, self._warn = folder, size, warn
        if not folder.is_dir():
            raise cannot_open(folder, "there is no such folder of images")
        if (folder / "poses.csv").is_file():
            files = [file for shots in images_of_poses(load(folder)) for file in shots.files]
        else:
            files = sorted(file for file in folder.iterdir() if file.suffix.lower() in ENDINGS)
        if not files:
            raise cannot_open(folder, "there is no image in it")
        self._images = map(CameraImages.of(files, size).grey, files)

    def shot(self, settle_s: float) -> Image:
        """The next image."""
        image = next(self._images, None)
        if image is None:
            raise no_more_images(self._folder, "all its images have been used")
        _check(self._folder, image, self._size, self._warn)
        return image

    def close(self) -> None:
        """There is nothing to close."""


Camera = LiveCamera | RecordedImages


def _check(source: object, image: Image, size: tuple[int, int], warn: Warn) -> None:
    """Check an image, (h, w), and warn of doubtful ones; `size` is width and height [px]."""
    if image.shape[::-1] != size:
        raise CameraError(
            f"Camera {source} gives images of {image.shape[1]} x {image.shape[0]} pixels, but dataset.toml,"
            f" [image] states {size[0]} x {size[1]}. Set the camera to that size, or correct [image]."
        )
    white = float((image >= WHITE).mean())
    if white > MOSTLY:
        raise CameraError(
            f"Camera {source} is overexposed: {white:.0%} of the image is white."
            " Set a shorter exposure or less gain in cell.toml, [camera], or close the aperture."
        )
    if white > MUCH:
        warn(f"camera {source}: {white:.0%} of the image is white; a shorter exposure shows more.")
    if image.max(initial=0) < DARK:
        warn(f"camera {source}: the whole image is dark. Is the lens covered, or the light off?")


def _cut_off(image: Image) -> bool:
    """Whether it is too dark or too bright to show the noise of a live camera."""
    return bool(image.max(initial=0) < DARK or image.min(initial=WHITE) >= WHITE)


def _opened(line: CameraLine, size: tuple[int, int], warn: Warn) -> tuple[Any, bool]:
    """A `cv2.VideoCapture`, and whether it returns encoded single images (PGM, PNG, Motion JPEG)."""
    capture: Any
    if isinstance(line.source, str) and "://" in line.source:
        capture, single = _open_stream(line.source)
    else:
        single, capture = False, cv2.VideoCapture(line.source)
        if not capture.isOpened():
            raise cannot_open(line.source, "there is no camera")
        capture.set(cv2.CAP_PROP_FRAME_WIDTH, size[0])  # the first image shows whether it could
        capture.set(cv2.CAP_PROP_FRAME_HEIGHT, size[1])
    if line.exposure is not None:
        capture.set(cv2.CAP_PROP_AUTO_EXPOSURE, MANUAL)
    for name, what, value in (
        ("exposure", cv2.CAP_PROP_EXPOSURE, line.exposure),
        ("gain", cv2.CAP_PROP_GAIN, line.gain),
    ):
        if value is not None and not capture.set(what, value):
            warn(f"camera {line.source}: its driver refuses {name} = {value:g}; the value is unchanged.")
    return capture, single


def _open_stream(source: str) -> tuple[Any, bool]:
    raw = _captured(source)
    raw.set(cv2.CAP_PROP_FORMAT, RAW)
    there, packet = raw.read()
    if there and packet.dtype == "uint8" and decoded(packet.tobytes(), cv2.IMREAD_GRAYSCALE) is not None:
        return raw, True
    raw.release()
    return _captured(source), False


def _captured(source: str) -> Any:
    limits = [cv2.CAP_PROP_OPEN_TIMEOUT_MSEC, OPENING_MS, cv2.CAP_PROP_READ_TIMEOUT_MSEC, READING_MS]
    one_thread = [cv2.CAP_PROP_N_THREADS, 1]  # each further one holds an image back
    capture: Any = cv2.VideoCapture(source, cv2.CAP_FFMPEG, limits + one_thread)
    if not capture.isOpened():
        raise cannot_open(source, "there is no stream")
    return capture


def cannot_open(source: object, reason: str) -> CameraError:
    """The error of a camera that is not there or not usable."""
    return CameraError(
        f"Cannot open camera {source}: {reason}. Check its cable or address, that no other program holds it, and"
        " name it in cell.toml, [camera] source, or with --camera."
    )


def no_more_images(source: object, reason: str) -> CameraError:
    """The error of a camera that sends no more images."""
    return CameraError(f"Camera {source} gives no more images: {reason}. Check its cable and power.")
