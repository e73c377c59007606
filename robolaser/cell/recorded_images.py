"""A camera made of recorded images: each shot is the next of them."""

from collections.abc import Iterator
from pathlib import Path
from typing import Any, final

import cv2

from robolaser.bounded_reading import IMAGE_BYTES, decoded, read_bytes
from robolaser.cell.camera import Camera, Warn, cannot_open, check_image, grey, no_more_images
from robolaser.data.image_list import images_of_poses
from robolaser.data.loading import load
from robolaser.vision.board import Image

ENDINGS = (".png", ".pgm", ".jpg", ".jpeg", ".bmp", ".tif", ".tiff")


@final
class RecordedImages(Camera):
    """A recording, a folder of images, a film, or numbered images such as "shot_%04d.png".

    A recording's shots come in the order in which they were taken, a folder's images by name.
    """

    def __init__(self, source: Path, size: tuple[int, int], warn: Warn, channel: str = "grey", bits: int = 16) -> None:
        self._source = source
        self._size = size
        self._warn = warn
        frames = _of_folder(source) if source.is_dir() else _of_film(source)
        self._pictures: Iterator[Image] = (grey(source, frame, channel, bits) for frame in frames)

    def shot(self, settle_s: float) -> Image:
        """An image of what is there from now on."""
        image = next(self._pictures, None)
        if image is None:
            raise no_more_images(self._source, "all its images have been used")
        check_image(self._source, image, self._size, self._warn)
        return image

    def close(self) -> None:
        """Close it."""
        self._pictures = iter(())


def _of_folder(folder: Path) -> Iterator[Any]:
    if (folder / "poses.csv").is_file():
        names = _shots(folder)
    else:
        names = sorted(str(file.name) for file in folder.iterdir() if file.suffix.lower() in ENDINGS)
    if not names:
        raise cannot_open(folder, "there is no image in it")

    def frames() -> Iterator[Any]:
        for name in names:
            frame = decoded(read_bytes(folder / name, IMAGE_BYTES), cv2.IMREAD_UNCHANGED)
            if frame is None:
                raise no_more_images(folder, f"{name} cannot be read")
            yield frame

    return frames()


def _shots(folder: Path) -> list[str]:
    """Images of a recording: of each pose all with the laser on, then the one without."""
    return [str(file.relative_to(folder)) for shots in images_of_poses(load(folder)) for file in shots.files]


def _of_film(source: Path) -> Iterator[Any]:
    capture: Any = cv2.VideoCapture(str(source))
    if not capture.isOpened():
        raise cannot_open(source, "it is neither a folder nor a film or numbered images")

    def frames() -> Iterator[Any]:
        while True:
            there, frame = capture.read()
            if not there:
                return
            yield frame

    return frames()
