"""A board whose corners or circles are found in images."""

from dataclasses import dataclass
from typing import Annotated, Literal, final

import numpy as np
from msgspec import Meta

from robolaser.arrays import Array
from robolaser.data.toml_schema import Positive

Printed = Literal["checkerboard", "charuco", "circles", "modified_circles"]


@final
@dataclass(frozen=True)
class Board:
    """A printed board."""

    columns: Annotated[int, Meta(ge=3)]  # inner corners along x, or circles
    rows: Annotated[int, Meta(ge=3)]  # the same along y
    square_m: Positive  # side of a square, or distance of circles [m]
    kind: Printed = "checkerboard"  # what is printed on it; one of the modified circles is larger, and is the origin
    marker_m: Positive | None = None  # side of a ChArUco board's markers [m]
    dictionary: str | None = None  # OpenCV's name of the markers' dictionary, such as "DICT_6X6_250"

    @property
    def corners(self) -> Array:
        """Its corners or circles in its own frame, (rows, columns, 3) [m]."""
        return self.square_m * np.pad(lattice(self.columns, self.rows), ((0, 0), (0, 0), (0, 1)))


def lattice(columns: int, rows: int) -> Array:
    """Corners in squares, or circles in their distances, (rows, columns, 2)."""
    return np.stack(np.meshgrid(np.arange(columns), np.arange(rows)), axis=-1).astype(np.float64)
