"""A camera that can be asked for one image of what is there now."""

from abc import ABC, abstractmethod
from collections.abc import Callable

from robolaser.errors import CameraError
from robolaser.vision.board import Image

Warn = Callable[[str], None]

WHITE = 250
"""Grey value from which on a pixel counts as saturated."""
MOSTLY = 0.5
MUCH = 0.1
"""Shares of white pixels: with the first an image is lost; a stripe alone never reaches the second."""
DARK = 12
"""Grey that some pixel exceeds in any image that shows something."""


class Camera(ABC):
    """Grey images of one size, (h, w) uint8."""

    @abstractmethod
    def shot(self, settle_s: float) -> Image:
        """An image of what is there from now on.

        Args:
            settle_s: Wait so long first [s]; 0: nothing has changed since the last shot.

        Raises:
            CameraError: No image comes, they are all the same, or the image is of no use.
        """

    @abstractmethod
    def close(self) -> None:
        """Close it."""


def cannot_open(source: object, reason: str) -> CameraError:
    """The error of a camera that is not there or not usable."""
    return CameraError(
        f"Cannot open camera {source}: {reason}. Check its cable or address, that no other program holds it, and"
        " name it in cell.toml, [camera] source, or with --camera."
    )


def no_more_images(source: object, reason: str) -> CameraError:
    """The error of a camera that falls silent."""
    return CameraError(f"Camera {source} gives no more images: {reason}. Check its cable and power.")


def check_image(source: object, image: Image, size: tuple[int, int], warn: Warn) -> None:
    """Look whether an image, (h, w), is fit to be kept, and warn of what is odd; its size is width and height [px].

    Raises:
        CameraError: It has another size, or most of it is white.
    """
    if image.shape[::-1] != size:
        raise CameraError(
            f"Camera {source} gives images of {image.shape[1]} x {image.shape[0]} pixels, but dataset.toml, [image]"
            f" says {size[0]} x {size[1]}. Set the camera to that size, or correct [image]."
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
