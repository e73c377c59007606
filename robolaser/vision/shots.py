"""The images taken at one pose, and the stripe's light in each."""

from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path
from typing import final

from robolaser.vision.board import Image
from robolaser.vision.images import laser_alone, read_grey


@final
@dataclass(frozen=True)
class Shots:
    """Files of one pose's images.

    Attributes:
        pose: Its name.
        lit: With the laser on: one, or several of the unmoved arm.
        unlit: With the laser off, where it was taken.
    """

    pose: str
    lit: tuple[Path, ...]
    unlit: Path | None = None

    def ambient(self, width_px: int, height_px: int) -> Image | None:
        """What shows without the laser, (height, width).

        Raises:
            ImageUnreadable, ImageSize: The image is missing, broken or of another size.
        """
        return None if self.unlit is None else read_grey(self.unlit, width_px, height_px)

    def lights(self, width_px: int, height_px: int, ambient: Image | None) -> Iterator[tuple[Image, Image]]:
        """Give each image with the laser on, and in it the laser's light as far as that is known, (height, width) each.

        Raises:
            ImageUnreadable, ImageSize: An image is missing, broken or of another size.
        """
        for path in self.lit:
            image = read_grey(path, width_px, height_px)
            yield image, image if ambient is None else laser_alone(image, ambient)
