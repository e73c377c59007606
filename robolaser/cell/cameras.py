"""What a cell names as its camera, opened."""

from robolaser.cell.camera import Camera, Warn
from robolaser.cell.clock import Clock
from robolaser.cell.live import Live
from robolaser.cell.pictures import Pictures
from robolaser.data.cell_config import Cell
from robolaser.errors import CameraUnusable


def open_camera(cell: Cell, clock: Clock, warn: Warn) -> Camera:
    """Open a cell's camera: a number, a device (/dev/...) or a stream (with ://) runs by itself, all else is files.

    Raises:
        CameraUnusable: It is not there, or the cell takes no images.
        CameraLost: It sends nothing.
    """
    source, size = cell.camera.source, cell.description.image_px
    if size is None:
        raise CameraUnusable(source, "dataset.toml has no [image], so nobody knows what size its images should have")
    if isinstance(source, int) or "://" in source or source.startswith("/dev/"):
        return Live(cell.camera, size, clock, warn)
    return Pictures(cell.beside(source), size, warn)
