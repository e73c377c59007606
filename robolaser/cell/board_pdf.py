"""A board as a page to print, in true size."""

import io

import numpy as np
from PIL import Image, ImageDraw, ImageFont

from robolaser.data.board import Board
from robolaser.data.printed_board import board_print
from robolaser.errors import UsageError

A4_M = (0.297, 0.210)
MARGIN_M = 0.01  # that printers leave white
PIXEL_M = 1e-3 / 12  # about, so that cells are whole numbers of pixels
INCH_M = 0.0254
LETTERS_M = 0.004


def board_pdf(board: Board) -> bytes:
    """A page (A4, landscape) with a board in its middle, and its sizes below.

    Raises:
        UsageError: The board does not fit.
        DataError: It cannot be drawn, see `board_print`.
    """
    printed = board_print(board)
    height, width = printed.dark.shape
    pixels = round(printed.cell_m / PIXEL_M)
    pixel_m = printed.cell_m / pixels
    if any(count * printed.cell_m > side - 2 * MARGIN_M for count, side in zip((width, height), A4_M, strict=True)):
        raise UsageError(
            f"A board of {board.columns + 1} x {board.rows + 1} squares of {1e3 * board.square_m:g} mm does not fit on"
            " A4. Take fewer columns or rows, or smaller squares."
        )
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
