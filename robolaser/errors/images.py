"""Images that cannot be read, and scanners that cannot be exported."""

from pathlib import Path

from robolaser.errors.base import RobolaserError


class ImageUnreadable(RobolaserError):
    """An image that is not there or cannot be decoded."""

    def __init__(self, path: Path, reason: str) -> None:
        super().__init__(f"{path}: {reason}. Name a grey or colour image that OpenCV reads, such as PNG.")


class ImageSize(RobolaserError):
    """An image of another size than the recording's."""

    def __init__(self, path: Path, found: tuple[int, int], expected: tuple[int, int]) -> None:
        super().__init__(
            f"{path} is {found[0]} x {found[1]} pixels, but width_px x height_px say {expected[0]} x {expected[1]}."
            " All images of a recording come from one camera at one size: correct the size or leave the image out."
        )


class NotARecording(RobolaserError):
    """A data set that points cannot be extracted from."""

    def __init__(self, reason: str) -> None:
        super().__init__(f"There are no points to extract: {reason}.")


class NothingExtracted(RobolaserError):
    """No image gave a point."""

    def __init__(self, images: int, reasons: str) -> None:
        super().__init__(
            f"None of {images} images gave a point ({reasons}). Check [board] columns and rows (inner corners, not "
            "squares), stripe_axis, and that board and stripe are both in view."
        )


class NoStripes(RobolaserError):
    """No image shows a stripe."""

    def __init__(self, images: int, axis: str) -> None:
        lines = "rows" if axis == "v" else "columns"
        super().__init__(
            f"None of {images} images shows a stripe that crosses the {lines} of pixels. Check that the laser is on, "
            f"the exposure, and [sensor] stripe_axis, which is '{axis}'."
        )


class NoCamera(RobolaserError):
    """A camera's file was asked for, from a sensor that has none."""

    def __init__(self, kind: str) -> None:
        super().__init__(f"A sensor of kind '{kind}' has no camera to describe; only 'stripe' has one.")
