"""Image files as arrays of grey, and the light of the laser alone in them."""

from collections.abc import Iterable
from dataclasses import dataclass
from itertools import takewhile
from pathlib import Path
from typing import Any, final

import cv2
import numpy as np
from numpy.typing import NDArray

from robolaser.arrays import Image
from robolaser.bounded_reading import IMAGE_BYTES, decoded, pixels_of, read_bytes
from robolaser.errors import DataError, ImageError
from robolaser.vision.runs import FULL

DEPTHS = (8, 10, 12, 14, 16)  # bits of grey of cameras; files of sixteen bits hold any of them
PEDESTAL = 16  # least grey of a difference of zero, so that negative noise is not cut off
BRIGHTEST_ROOM = 200  # least grey without the laser of a pixel that a lamp saturates
SATURATED_FULL = 95.0  # percentage of the pixels saturated by the laser that are full in the difference


Weights = tuple[float, float, float]  # of blue, green and red in a channel
Raw = NDArray[Any]


@final
@dataclass(frozen=True)
class CameraImages:
    """Format of the image files of one camera."""

    size_px: tuple[int, int]  # width and height of each
    depth: int = 8  # bits of grey of the camera

    @classmethod
    def of(cls, files: Iterable[Path], size_px: tuple[int, int]) -> "CameraImages":
        """The format with the depth that all files need together: a dark image of twelve bits does not show its own."""
        raw = (read_image(file, size_px, cv2.IMREAD_ANYCOLOR) for file in files)
        deep = takewhile(lambda image: image.dtype != np.uint8, raw)  # of one camera: one of eight bits is enough
        return cls(size_px, max(map(depth_of, deep), default=8))

    def grey(self, file: Path) -> Image:
        """An image as eight bits of grey, (height, width)."""
        return eight_bits(read_image(file, self.size_px, cv2.IMREAD_GRAYSCALE), self.depth)


def read_image(path: Path, size_px: tuple[int, int], colours: int) -> Raw:
    """An image as in its file: 8 or 16 bits, grey (height, width) or blue, green and red, (height, width, 3).

    Raises:
        ImageError: It is missing, no image, or of another size.
    """
    try:
        coded = read_bytes(path, IMAGE_BYTES)
    except DataError as error:
        raise ImageError(f"{error} Name a grey or colour image that OpenCV reads, such as PNG.") from None
    stated = pixels_of(coded)
    if stated is not None and stated[0] * stated[1] != size_px[0] * size_px[1]:
        raise _of_another_size(path, stated, size_px)
    image = decoded(coded, colours | cv2.IMREAD_ANYDEPTH)
    if image is None or image.dtype not in (np.uint8, np.uint16):
        raise ImageError(
            f"{path}: not an image of a known format, damaged, or larger than any camera's. Name a grey or colour image"
            " that OpenCV reads, such as PNG."
        )
    if image.shape[:2] != size_px[::-1]:
        raise _of_another_size(path, (image.shape[1], image.shape[0]), size_px)
    return np.asarray(image)


def depth_of(image: Raw) -> int:
    """Bits of grey that an image needs: 8, or 10, 12, 14 or 16, as cameras have."""
    used = int(image.max(initial=0)).bit_length()
    return next(bits for bits in DEPTHS if used <= bits)


def eight_bits(image: Raw, depth: int) -> Image:
    """An image of a camera with a given depth as eight bits; brighter values are full."""
    if image.dtype == np.uint8:
        return np.asarray(image, np.uint8)
    return np.asarray(np.minimum(image >> (depth - 8), FULL), np.uint8)


def light_in(image: Raw, depth: int, weights: Weights | None) -> Image:
    """A channel of an image on the scale of eight bits, (height, width); deeper ones keep their fractions."""
    if image.dtype == np.uint8 and weights is None:
        return np.asarray(image, np.uint8)
    light: Any = image.astype(np.float32) / np.float32(1 << (depth - 8))
    if weights is not None:
        mixed = light @ np.asarray(weights, np.float32)
        full = light[..., np.argmax(weights)] >= FULL
        light = np.where(full, FULL, mixed + PEDESTAL) if min(weights) < 0 else mixed
    light = np.clip(light, 0, FULL)
    return np.asarray(np.rint(light), np.uint8) if image.dtype == np.uint8 else np.asarray(light, np.float32)


def _of_another_size(path: Path, here: tuple[int, int], stated: tuple[int, int]) -> ImageError:
    return ImageError(
        f"{path} is {here[0]} x {here[1]} pixels, but width_px x height_px say {stated[0]} x {stated[1]}. All images of"
        " a recording come from one camera at one size: correct the size or leave the image out."
    )


def laser_alone(lit: Image, unlit: Image) -> Image:
    """The laser's light in an image, on an even background; pixels that it saturated are full."""
    room = unlit[lit == FULL]
    room = room[room < BRIGHTEST_ROOM]
    ground = max(PEDESTAL, int(np.percentile(room, SATURATED_FULL)) if len(room) else 0)
    alone = cv2.addWeighted(lit, 1.0, unlit, -1.0, ground)
    return np.asarray(np.clip(alone, 0, FULL), dtype=lit.dtype)
