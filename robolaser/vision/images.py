"""Image files as arrays of grey, and what a laser alone lights in them."""

from collections.abc import Iterator
from pathlib import Path
from typing import Any

import cv2
import numpy as np
from numpy.typing import NDArray

from robolaser.bounded_reading import IMAGE_BYTES, pixels_of, read_bytes
from robolaser.data.image_list import PoseImages
from robolaser.errors import DataError, ImageError
from robolaser.vision.board import Image
from robolaser.vision.profile_levels import FULL

DEPTHS = (8, 10, 12, 14, 16)
"""Bits of grey that cameras tell apart; files of sixteen bits hold any of them."""
PEDESTAL = 16
"""Least grey of a difference where nothing was added, so that noise below nothing is not cut off."""
BRIGHTEST_ROOM = 200
"""Grey without the laser from which on a pixel is a lamp, full by itself."""
SATURATED_FULL = 95.0
"""Percentage of the pixels that the laser saturated which are to be full in the difference."""


def read_grey(path: Path, width_px: int, height_px: int) -> Image:
    """Read an image, (height, width).

    Raises:
        ImageError: It is missing, no image, or of another size.
    """
    try:
        coded = read_bytes(path, IMAGE_BYTES)
    except DataError as error:
        raise ImageError(f"{error} Name a grey or colour image that OpenCV reads, such as PNG.") from None
    stated = pixels_of(coded)
    if stated is not None and stated[0] * stated[1] != width_px * height_px:
        raise _of_another_size(path, stated, (width_px, height_px))
    flags = cv2.IMREAD_GRAYSCALE | cv2.IMREAD_ANYDEPTH
    image = None if stated is None else cv2.imdecode(np.frombuffer(coded, np.uint8), flags)
    if image is None or image.dtype not in (np.uint8, np.uint16):
        raise _unreadable(path, "not an image of a known format, damaged, or larger than any camera's")
    if image.shape != (height_px, width_px):
        raise _of_another_size(path, (image.shape[1], image.shape[0]), (width_px, height_px))
    return np.asarray(image if image.dtype == np.uint8 else _eight_bits(image), dtype=np.uint8)


def _eight_bits(image: NDArray[Any]) -> NDArray[Any]:
    """Deeper grey as eight bits, by the depth that cameras have: 10, 12, 14 or 16 bits."""
    used = int(image.max(initial=0)).bit_length()
    depth = next(bits for bits in DEPTHS if used <= bits)
    return image >> (depth - 8)


def _of_another_size(path: Path, here: tuple[int, int], stated: tuple[int, int]) -> ImageError:
    return ImageError(
        f"{path} is {here[0]} x {here[1]} pixels, but width_px x height_px say {stated[0]} x {stated[1]}. All images of"
        " a recording come from one camera at one size: correct the size or leave the image out."
    )


def _unreadable(path: Path, reason: str) -> ImageError:
    return ImageError(f"{path}: {reason}. Name a grey or colour image that OpenCV reads, such as PNG.")


def laser_alone(lit: Image, unlit: Image) -> Image:
    """What the laser adds to an image, on an even ground; what it saturated is full here too."""
    room = unlit[lit == FULL]
    room = room[room < BRIGHTEST_ROOM]
    ground = max(PEDESTAL, int(np.percentile(room, SATURATED_FULL)) if len(room) else 0)
    return np.asarray(cv2.addWeighted(lit, 1.0, unlit, -1.0, ground), dtype=np.uint8)


def ambient(shots: PoseImages, size_px: tuple[int, int]) -> Image | None:
    """What a pose shows without the laser, (height, width); None where no such image was taken.

    Raises:
        ImageError: The image is missing, broken or of another size.
    """
    return None if shots.unlit is None else read_grey(shots.unlit, *size_px)


def lights(shots: PoseImages, size_px: tuple[int, int], without: Image | None) -> Iterator[tuple[Image, Image]]:
    """Give each image with the laser on, and in it the laser's light as far as that is known, (height, width) each.

    Args:
        shots: Of a pose.
        size_px: Width and height that each must have.
        without: What shows without the laser, where that is known.

    Raises:
        ImageError: An image is missing, broken or of another size.
    """
    for path in shots.lit:
        image = read_grey(path, *size_px)
        yield image, image if without is None else laser_alone(image, without)
