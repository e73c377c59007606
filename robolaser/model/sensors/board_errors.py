"""How errors of a board's corners shift the rows whose place on it they tell."""

import numpy as np

from robolaser.arrays import Array
from robolaser.data.board import Board
from robolaser.data.dataset import Points
from robolaser.model.error_source import ErrorSource


def board_errors(board: Board, points: Points, T_base_target: Array) -> ErrorSource:
    """`board` [m], of each corner along x and y of the board, shared by all rows of an image.

    Where rows come from images of a board, a homography through its corners says where on the board each pixel lies.
    It errs as the corners do, alike for all rows: without this source the rows, being many, would seem to know the
    board's place from each pose better than its corners do.
    """
    last = np.array([board.columns - 1, board.rows - 1])
    steps = [np.arange(end + 1) - end / 2 for end in last]
    corners = _homographies(np.stack(np.meshgrid(*steps), axis=-1).reshape(-1, 2))
    of_unit_error = np.linalg.inv(np.linalg.qr(corners.reshape(-1, 8)).R)
    on_board = _homographies(points["xyz"][:, :2] / board.square_m - last / 2) @ of_unit_error
    return ErrorSource("board", T_base_target[:3, :2] @ on_board, points.pose, level="point")


def _homographies(at: Array) -> Array:
    """Small motions of points (m, 2) by each of a homography's eight numbers, (m, 2, 8)."""
    x, y = at.T
    one, none = np.ones_like(x), np.zeros_like(x)
    along_x = np.stack([one, none, x, y, none, none, x * x, x * y], axis=-1)
    along_y = np.stack([none, one, none, none, x, y, x * y, y * y], axis=-1)
    return np.stack([along_x, along_y], axis=1)
