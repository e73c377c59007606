"""A ChArUco board in an image: a checkerboard whose markers name its corners, so that a part of it is enough."""

from functools import cache

import cv2
import numpy as np

from robolaser.arrays import Array, Image
from robolaser.data.board import Board
from robolaser.data.printed_board import dictionary
from robolaser.vision.board import sharpened

WINDOW_PX = (2, 8)  # half sides of the window in which a corner is sharpened, least and most


def find_charuco(image: Image, board: Board) -> Array | None:
    """Corners by their names, (rows, columns, 2) [px] as (u, v), NaN where one is not seen; None where none is.

    Boards of OpenCV before 4.6, with a light first square where their rows are even, are read too.

    Args:
        image: Grey image, (height, width).
        board: Its markers' dictionary among what it says.

    Raises:
        DataError: OpenCV has no dictionary of that name.
    """
    seen = [_seen(image, board, legacy=legacy) for legacy in (False, True)]
    grid = max(seen, key=lambda one: np.isfinite(one).sum())
    return grid if np.isfinite(grid).any() else None


def _sharpened(image: Image, grid: Array, board: Board) -> Array:
    """The corners where the squares' edges cross, looked at no farther than the markers leave room."""
    steps = [np.linalg.norm(np.diff(grid, axis=axis), axis=-1) for axis in (0, 1)]
    pitch = np.concatenate([step[np.isfinite(step)] for step in steps])
    there = np.isfinite(grid).all(axis=-1)
    if not len(pitch):
        return grid
    room = float(pitch.min()) * (1.0 - float(board.marker_m or 0.0) / board.square_m) / 2.0
    half = int(np.clip(room, *WINDOW_PX))
    grid = grid.copy()
    grid[there] = sharpened(image, grid[there], half)
    return grid


@cache
def _detector(board: Board, *, legacy: bool) -> cv2.aruco.CharucoDetector:
    squares = (board.columns + 1, board.rows + 1)
    markers = cv2.aruco.getPredefinedDictionary(dictionary(board))
    printed = cv2.aruco.CharucoBoard(squares, board.square_m, float(board.marker_m or 0.0), markers)
    printed.setLegacyPattern(legacy)
    return cv2.aruco.CharucoDetector(printed)


def _seen(image: Image, board: Board, *, legacy: bool) -> Array:
    grid = np.full((board.rows, board.columns, 2), np.nan)
    corners, names, *_ = _detector(board, legacy=legacy).detectBoard(image)
    if names is not None:
        row, column = np.divmod(np.ravel(names), board.columns)
        grid[row, column] = np.reshape(corners, (-1, 2))
        grid = _sharpened(image, grid, board)
    # The origin's outward diagonal square is dark: with a light first one, that of the last corner may be.
    first_is_light = legacy and board.rows % 2 == 1
    return grid[::-1, ::-1] if first_is_light and board.columns % 2 == 0 else grid
