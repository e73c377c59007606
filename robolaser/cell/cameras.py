"""What a cell names as its camera, opened."""

from typing import Any

from robolaser.cell.camera import Camera, Warn, cannot_open
from robolaser.cell.clock import Clock
from robolaser.cell.live_camera import LiveCamera
from robolaser.cell.recorded_images import RecordedImages
from robolaser.data.cell_config import FILE, Cell
from robolaser.errors import DataError, near
from robolaser.plugins import announced

GROUP = "robolaser.cameras"
"""Entry points of installed packages that announce cameras; the entry point's name is the kind."""

STREAMS = ("tcp", "udp", "rtp", "rtsp", "rtsps", "http", "https")
"""Of URLs that may be opened: FFmpeg knows many more, which read other files or write."""


def open_camera(cell: Cell, clock: Clock, warn: Warn) -> Camera:
    """Open a cell's camera: a number, a device (/dev/...) or a stream (with ://) runs by itself, all else is files.

    Raises:
        CameraError: It is not there, sends nothing, or the cell takes no images.
        DataError: No installed package announces a camera of its kind.
        PluginError: One does, but it cannot be used.
    """
    if cell.camera.kind:
        others = announced(GROUP, Camera, taken=(), name="", required=("open",))
        if cell.camera.kind not in others:
            raise DataError(
                f"{FILE}, [camera] kind: no installed package announces a camera"
                f" '{cell.camera.kind}'.{near(cell.camera.kind, others)}",
                file=FILE,
                column="kind",
            )
        announced_camera: Any = others[cell.camera.kind]
        opened: Camera = announced_camera.open(cell, clock, warn)
        return opened
    source, size = cell.camera.source, cell.description.image_px
    if size is None:
        raise cannot_open(source, "dataset.toml has no [image] that states the size of its images")
    scheme, separator, _ = str(source).partition("://")
    if separator and scheme.lower() not in STREAMS:
        raise cannot_open(source, f"{scheme}:// is not allowed, only {', '.join(STREAMS)}")
    if isinstance(source, int) or "://" in source or source.startswith("/dev/"):
        return LiveCamera(cell.camera, size, clock, warn)
    return RecordedImages(cell.beside(source), size, warn, cell.camera.channel, cell.camera.bits)
