"""What a cell names as its camera, opened: a live one, or images that were recorded."""

from pathlib import Path
from typing import final

from robolaser.cell.camera import Camera, Warn, cannot_open, check_image, no_more_images
from robolaser.cell.clock import Clock
from robolaser.cell.live_camera import LiveCamera
from robolaser.data.cell_config import Cell
from robolaser.vision.board import Image
from robolaser.vision.images import CameraImages

STREAMS = ("tcp", "udp", "rtp", "rtsp", "rtsps", "http", "https")
"""Of URLs that may be opened: FFmpeg knows many more, which read other files or write."""
ENDINGS = (".png", ".pgm", ".jpg", ".jpeg", ".bmp", ".tif", ".tiff")


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
