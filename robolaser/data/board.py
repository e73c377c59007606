"""A board whose corners or circles are found in images."""

from dataclasses import dataclass
from typing import Annotated, Literal, final

from msgspec import Meta

from robolaser.data.toml_schema import Positive

Printed = Literal["checkerboard", "charuco", "circles", "modified_circles"]


@final
@dataclass(frozen=True)
class Board:
    """A printed board.

    Attributes:
        columns: Inner corners along x, or circles.
        rows: The same along y.
        square_m: Side of a square, or distance of circles [m].
        kind: What is printed on it; one of the modified circles is larger, and is the origin.
        marker_m: Side of a ChArUco board's markers [m].
        dictionary: OpenCV's name of the markers' dictionary, such as "DICT_6X6_250".
    """

    columns: Annotated[int, Meta(ge=3)]
    rows: Annotated[int, Meta(ge=3)]
    square_m: Positive
    kind: Printed = "checkerboard"
    marker_m: Positive | None = None
    dictionary: str | None = None
