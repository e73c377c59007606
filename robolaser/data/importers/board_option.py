"""A printed board as a person states it on one line."""

import re
from collections.abc import Mapping
from typing import Final

from robolaser.data.board import Board
from robolaser.data.csv_tables import finite
from robolaser.errors import UsageError, near
from robolaser.geometry.units import FACTORS, LENGTH

BOARD: Final = "board"  # option that says what is printed on the board
KINDS = ("checkerboard", "charuco", "circles", "modified_circles")
FORM = "--set board=checkerboard,7x6,10mm or --set board=charuco,4x6,36mm,18mm,DICT_6X6_250 (inner corners in x and y)"
DIGITS = 12  # 36 mm are 0.036 m, and not 0.036000000000000004
_LENGTH = re.compile(r"(?P<number>[0-9.eE+-]+)(?P<unit>[a-z]+)")


def board_of(further: Mapping[str, str]) -> Board | None:
    """The board that `--set board=KIND,COLUMNSxROWS,SQUARE[,MARKER,DICTIONARY]` states; None where nothing is.

    Raises:
        UsageError: What is stated is no board.
    """
    if BOARD not in further:
        return None
    stated = further[BOARD]
    kind, *rest = (part.strip() for part in stated.split(","))
    if kind not in KINDS:
        raise UsageError(f"--set board={stated}: no board of kind '{kind}'.{near(kind, KINDS)} Write {FORM}.")
    counts = re.fullmatch(r"(\d{1,4})x(\d{1,4})", rest[0]) if rest else None
    if counts is None or len(rest) != (4 if kind == "charuco" else 2):
        raise UsageError(f"--set board={stated}: expected {FORM}.")
    square, *markers = rest[1:]
    return Board(
        columns=int(counts[1]),
        rows=int(counts[2]),
        square_m=_metres(square, stated),
        kind=kind,  # type: ignore[arg-type]
        marker_m=_metres(markers[0], stated) if markers else None,
        dictionary=markers[1] if markers else None,
    )


def _metres(text: str, stated: str) -> float:
    found = _LENGTH.fullmatch(text)
    factor = FACTORS[LENGTH].get(found["unit"]) if found else None
    value = round(finite(found["number"]) * factor, DIGITS) if found and factor else 0.0
    if not 0 < value < 100:
        raise UsageError(f"--set board={stated}: {text} is no length with a unit, such as 10mm or 0.01m.")
    return value
