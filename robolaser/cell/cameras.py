"""What a cell names as its camera, opened: one that runs by itself, or a folder of images."""

import threading
from pathlib import Path
from typing import Any, final

import cv2
import numpy as np

from robolaser.bounded_reading import decoded
from robolaser.cell.camera import DARK, WHITE, Camera, Warn, cannot_open, check_image, no_more_images
from robolaser.cell.clock import Clock
from robolaser.data.cell_config import CameraLine, Cell
from robolaser.errors import CameraError, RobolaserError
from robolaser.vision.board import Image
from robolaser.vision.images import CameraImages

STREAMS = ("tcp", "udp", "rtp", "rtsp", "rtsps", "http", "https")
"""Of URLs that may be opened: FFmpeg knows many more, which read other files or write."""
ENDINGS = (".png", ".pgm", ".jpg", ".jpeg", ".bmp", ".tif", ".tiff")
SILENT_S = 2.0
"""A camera that sends no image for so long is lost."""
FIRST_S = 8.0
"""The first image may take longer: streams are analysed, exposures adjusted."""
MANUAL = 1.0
"""What most drivers (V4L2) call exposure by hand."""
PASSED_ON = 2
"""Images that may have been exposed before they were wanted, and waited somewhere in between."""
OPENING_MS = 8000  # of a stream,
READING_MS = 2000  # and of its next image
RAW = -1.0  # format by which OpenCV hands images on as they were sent: its own decoding hides a change of size


def open_camera(cell: Cell, clock: Clock, warn: Warn) -> Camera:
    """Open a cell's camera: a number, a device (/dev/...) or a stream (with ://) runs by itself, all else is a folder.

    Raises:
        CameraError: It is not there, sends nothing, or the cell takes no images.
        RobolaserError: An image in its place cannot be read.
    """
    source, size = cell.camera.source, cell.description.image_px
    if size is None:
        raise cannot_open(source, "dataset.toml has no [image] that states the size of its images")
    scheme, separator, _ = str(source).partition("://")
    if separator and scheme.lower() not in STREAMS:
        raise cannot_open(source, f"{scheme}:// is not allowed, only {', '.join(STREAMS)}")
    if isinstance(source, int) or "://" in source or source.startswith("/dev/"):
        return LiveCamera(cell.camera, size, clock, warn)
    return RecordedImages(cell.beside(source), size, warn)


@final
class RecordedImages(Camera):
    """A folder in place of a camera: each shot is the next image by name."""

    def __init__(self, folder: Path, size: tuple[int, int], warn: Warn) -> None:
        self._folder, self._size, self._warn = folder, size, warn
        if not folder.is_dir():
            raise cannot_open(folder, "there is no such folder of images")
        files = sorted(file for file in folder.iterdir() if file.suffix.lower() in ENDINGS)
        if not files:
            raise cannot_open(folder, "there is no image in it")
        self._images = map(CameraImages.of(files, size).grey, files)

    def shot(self, settle_s: float) -> Image:
        """The next image."""
        image = next(self._images, None)
        if image is None:
            raise no_more_images(self._folder, "all its images have been used")
        check_image(self._folder, image, self._size, self._warn)
        return image

    def close(self) -> None:
        """There is nothing to close."""


@final
class _ImageStream:
    """A stream of single images (PGM, PNG, Motion JPEG), each decoded by itself."""

    def __init__(self, capture: Any) -> None:
        self._capture = capture

    def read(self) -> tuple[bool, Image | None]:
        """The next image, as `cv2.VideoCapture.read`; a torn one is left out."""
        while True:
            there, packet = self._capture.read()
            image = decoded(packet.tobytes(), cv2.IMREAD_GRAYSCALE) if there else None
            if not there or image is not None:
                return there, image

    def set(self, what: int, value: float) -> bool:
        """Nothing can be set through a stream."""
        return False

    def release(self) -> None:
        """Close it."""
        self._capture.release()


@final
class LiveCamera(Camera):
    """A device or a stream, read in a thread of its own: its newest image is kept, older ones are discarded."""

    def __init__(self, line: CameraLine, size: tuple[int, int], clock: Clock, warn: Warn) -> None:
        self._source = line.source
        self._size = size
        self._clock = clock
        self._warn = warn
        self._capture = _opened(line, size, warn)
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
        """An image of what is there from now on."""
        self._clock.wait(settle_s)
        with self._news:
            wanted = self._count + 1 + (PASSED_ON if settle_s else 0)
        image = self._wait_for(wanted, SILENT_S)
        check_image(self._source, image, self._size, self._warn)
        return image

    def close(self) -> None:
        """Close it."""
        self._closing = True
        self._reader.join(SILENT_S)
        if not self._reader.is_alive():  # a driver that hangs is left to hang
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
                image = _grey(self._source, frame) if there else None
                end = None if there else no_more_images(self._source, "it has ended or was unplugged")
            except RobolaserError as error:
                image, end = None, error
            except Exception as error:  # whatever a driver throws, the one who waits must hear of it
                image, end = None, no_more_images(self._source, str(error))
            with self._news:
                self._keep(image)
                self._end = end
                self._news.notify_all()

    def _keep(self, image: Image | None) -> None:
        if image is None:
            return
        if self._image is not None and np.array_equal(image, self._image):
            self._same += 1
        else:
            self._same, self._same_s = 0, self._clock.now()
        self._image, self._count = image, self._count + 1


def _grey(source: object, frame: Any) -> Image:
    """An image as OpenCV delivers it, (h, w) or (h, w, 3), as (h, w) uint8."""
    if frame.dtype != np.uint8:
        raise cannot_open(source, f"its images hold {frame.dtype}, expected integers of 8 bits")
    return np.asarray(frame if frame.ndim == 2 else cv2.cvtColor(frame, cv2.COLOR_BGR2GRAY), dtype=np.uint8)


def _cut_off(image: Image) -> bool:
    """Whether so little or so much light fell into it that no noise is left to tell a live camera by."""
    return bool(image.max(initial=0) < DARK or image.min(initial=WHITE) >= WHITE)


def _opened(line: CameraLine, size: tuple[int, int], warn: Warn) -> Any:
    if isinstance(line.source, str) and "://" in line.source:
        capture: Any = _open_stream(line.source)
    else:
        capture = cv2.VideoCapture(line.source)
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
            warn(f"camera {line.source}: its driver refuses {name} = {value:g}; it stays as it is.")
    return capture


def _open_stream(source: str) -> Any:
    """Open a stream: what `cv2.VideoCapture` gives, or `_ImageStream` where the stream is made of single images."""
    raw = _captured(source)
    raw.set(cv2.CAP_PROP_FORMAT, RAW)
    there, packet = raw.read()
    if there and packet.dtype == "uint8" and decoded(packet.tobytes(), cv2.IMREAD_GRAYSCALE) is not None:
        return _ImageStream(raw)
    raw.release()
    return _captured(source)


def _captured(source: str) -> Any:
    settings = {
        cv2.CAP_PROP_OPEN_TIMEOUT_MSEC: OPENING_MS,
        cv2.CAP_PROP_READ_TIMEOUT_MSEC: READING_MS,
        cv2.CAP_PROP_N_THREADS: 1,  # each further one holds an image back
    }
    pairs = [number for setting in settings.items() for number in setting]
    capture: Any = cv2.VideoCapture(source, cv2.CAP_FFMPEG, pairs)
    if not capture.isOpened():
        raise cannot_open(source, "there is no stream")
    return capture
