"""Streams of images over a network, as they were sent: OpenCV's own decoding hides a change of size."""

from typing import Any, final

import cv2

from robolaser.bounded_reading import decoded
from robolaser.cell.camera import cannot_open
from robolaser.vision.board import Image

OPENING_MS = 8000
READING_MS = 2000
RAW = -1.0


@final
class ImageStream:
    """A stream of single images (PGM, PNG, Motion JPEG), each decoded by itself."""

    def __init__(self, capture: Any, colours: int) -> None:
        self._capture = capture
        self._colours = colours

    def read(self) -> tuple[bool, Image | None]:
        """The next image, as `cv2.VideoCapture.read`; a torn one is left out."""
        while True:
            there, packet = self._capture.read()
            image = decoded(packet.tobytes(), self._colours) if there else None
            if not there or image is not None:
                return there, image

    def set(self, what: int, value: float) -> bool:
        """Nothing can be set through a stream."""
        return False

    def release(self) -> None:
        """Close it."""
        self._capture.release()


def open_stream(source: str, *, in_colour: bool = False) -> Any:
    """Open a stream: what `cv2.VideoCapture` gives, or `ImageStream` where the stream is made of single images.

    Args:
        source: Its URL.
        in_colour: Whether single images are decoded as blue, green and red; else as grey.

    Raises:
        CameraError: There is none.
    """
    colours = cv2.IMREAD_COLOR if in_colour else cv2.IMREAD_GRAYSCALE
    raw = _opened(source)
    raw.set(cv2.CAP_PROP_FORMAT, RAW)
    there, packet = raw.read()
    if there and packet.dtype == "uint8" and decoded(packet.tobytes(), colours) is not None:
        return ImageStream(raw, colours)
    raw.release()
    return _opened(source)


def _opened(source: str) -> Any:
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
