"""A board whose corners or circles are found in images, and the page in true size that it is printed on."""

import io
from dataclasses import dataclass
from typing import Annotated, Literal, final

import numpy as np
from msgspec import Meta

from robolaser.arrays import Array, Bools
from robolaser.data.toml_schema import Positive, lacking, refused, wrong
from robolaser.errors import DataError

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

    def check(self) -> None:
        """Check that it can be printed."""
        for key, value in {"marker_m": self.marker_m, "dictionary": self.dictionary}.items():
            if self.kind == "charuco" and value is None:
                raise lacking(FILE, f"[board] {key}", ", which a ChArUco board needs")
            if self.kind != "charuco" and value is not None:
                raise wrong(FILE, ("board", key), value, f"no {key}: only a ChArUco board has markers")
        if self.kind == "charuco":
            dictionary(self)
        if self.marker_m is not None and self.marker_m >= self.square_m:
            raise wrong(FILE, ("board", "marker_m"), self.marker_m, f"less than square_m, {self.square_m:g}")


def lattice(columns: int, rows: int) -> Array:
    """Corners in squares, or circles in their distances, (rows, columns, 2)."""
    return np.stack(np.meshgrid(np.arange(columns), np.arange(rows)), axis=-1).astype(np.float64)


FILE = "dataset.toml"
EXACT = 1e-6
A4_M = (0.297, 0.210)
PIXEL_M = 1e-3 / 12  # about, so that cells are whole numbers of pixels
INCH_M = 0.0254
LETTERS_M = 0.004


@final
@dataclass(frozen=True, eq=False)
class BoardPrint:
    """A checkerboard, with or without markers."""

    dark: Bools  # cells, (h, w): rows along y of the board's frame, columns along x
    cell_m: float  # side of a cell [m]
    first: int  # cells from the edge of the print to the frame's origin, along x and along y


def board_print(board: Board) -> BoardPrint:
    """The print of a checkerboard or a ChArUco board (of OpenCV 4.6 or newer).

    Raises:
        DataError: It has circles, OpenCV has no such dictionary or too few markers in it, or its squares are no
            multiple of its markers' bits.
    """
    if board.kind == "checkerboard":
        dark = np.indices((board.rows + 1, board.columns + 1)).sum(axis=0) % 2 == 0
        return BoardPrint(dark, board.square_m, 1)
    if board.kind != "charuco":
        raise _not_printed(f"a board of kind '{board.kind}'")
    import cv2  # noqa: PLC0415 - slow to import

    markers = cv2.aruco.getPredefinedDictionary(dictionary(board))
    bits = markers.markerSize + 2  # with its frame
    marker_m = float(board.marker_m or 0.0)
    cells = board.square_m / marker_m * bits
    if abs(cells - round(cells)) > EXACT or (round(cells) - bits) % 2:
        raise _not_printed(
            f"a marker of {bits} bits and {1e3 * marker_m:g} mm in squares of {1e3 * board.square_m:g} mm"
        )
    squares = (board.columns + 1, board.rows + 1)
    if squares[0] * squares[1] // 2 > len(markers.bytesList):
        raise _not_printed(f"a board of {squares[0]} x {squares[1]} squares with markers of {board.dictionary}")
    drawn = cv2.aruco.CharucoBoard(squares, board.square_m, marker_m, markers)
    image = drawn.generateImage((squares[0] * round(cells), squares[1] * round(cells)))
    return BoardPrint(np.asarray(image) < 128, board.square_m / round(cells), round(cells))


def dictionary(board: Board) -> int:
    """OpenCV's number of the dictionary of a board's markers."""
    known = dictionaries()
    if board.dictionary not in known:
        spelt_once = {number: name for name, number in known.items()}
        expected = f"one of OpenCV's: {', '.join(spelt_once.values())}"
        raise wrong(FILE, ("board", "dictionary"), board.dictionary, expected, tuple(known))
    return known[board.dictionary]


def dictionaries() -> dict[str, int]:
    """OpenCV's number of each dictionary of markers, by its names."""
    from cv2 import aruco  # noqa: PLC0415 - slow to import

    return {name: getattr(aruco, name) for name in dir(aruco) if name.startswith("DICT_")}


def _not_printed(what: str) -> DataError:
    why = "cannot be drawn. Use a checkerboard, or ChArUco squares 4/3 as wide as their markers of 4 x 4 bits."
    return refused(FILE, "[board]", f"{what} {why}")


def board_pdf(board: Board) -> bytes:
    """A page (A4, landscape) with a board of squares that fits on it in its middle, and its sizes below."""
    from PIL import Image, ImageDraw, ImageFont  # noqa: PLC0415 - slow to import

    printed = board_print(board)
    pixels = round(printed.cell_m / PIXEL_M)
    pixel_m = printed.cell_m / pixels
    page_px = [round(side / pixel_m) for side in A4_M]
    page = Image.new("1", (page_px[0], page_px[1]), 1)
    board_px = np.kron(~printed.dark, np.ones((pixels, pixels), dtype=np.bool_))
    left, top = ((page_px[i] - board_px.shape[1 - i]) // 2 for i in (0, 1))
    page.paste(Image.fromarray(board_px), (left, top))
    letters = ImageFont.load_default(LETTERS_M / pixel_m)
    under = (left, (top + board_px.shape[0] + page_px[1]) // 2)
    ImageDraw.Draw(page).text(under, _sizes(board), fill=0, font=letters, anchor="lm")
    file = io.BytesIO()
    page.save(file, "PDF", resolution=INCH_M / pixel_m, creationDate=None, modDate=None)
    return file.getvalue()


def _sizes(board: Board) -> str:
    squares = board.columns + 1
    markers = "" if board.marker_m is None else f", markers of {1e3 * board.marker_m:g} mm ({board.dictionary})"
    return (
        f"{squares} x {board.rows + 1} squares of {1e3 * board.square_m:g} mm{markers}. Print at 100 %: the longer side"
        f" measures {1e3 * squares * board.square_m:g} mm."
    )
