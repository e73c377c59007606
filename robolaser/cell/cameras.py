"""What a cell names as its camera, opened."""

from robolaser.cell.camera import Camera, Warn, cannot_open
from robolaser.cell.clock import Clock
from robolaser.cell.live_camera import LiveCamera
from robolaser.cell.recorded_images import RecordedImages
from robolaser.data.cell_config import Cell


def open_camera(cell: Cell, clock: Clock, warn: Warn) -> Camera:
    """Open a cell's camera: a number, a device (/dev/...) or a stream (with ://) runs by itself, all else is files.

    Raises:
        CameraError: It is not there, sends nothing, or the cell takes no images.
    """
    source, size = cell.camera.source, cell.description.image_px
    if size is None:
        raise cannot_open(source, "dataset.toml has no [image] that states the size of its images")
    if isinstance(source, int) or "://" in source or source.startswith("/dev/"):
        return LiveCamera(cell.camera, size, clock, warn)
    return RecordedImages(cell.beside(source), size, warn)
