"""What errors of pixels, and of the corners of a board, do to a stripe's rows."""

from typing import Any, cast

import numpy as np

from robolaser.arrays import Array
from robolaser.data.board import Board
from robolaser.data.dataset import Dataset, Points
from robolaser.duals import Dual, bare
from robolaser.model.chain_rule import ChainRule
from robolaser.model.error_source import ErrorSource
from robolaser.model.sensors import scanner_geometry
from robolaser.model.sensors.placements import motion
from robolaser.model.stages import Perturbation
from robolaser.parameters import Values

PIXEL_STEP_PX = 0.25  # of what effects do with pixels: far above rounding, far below the lens's curvature
LARGEST_PX = 0.1
"""Of a corner that was found: what moves the rows of an image together by more is no error of corners."""


def pixel_moves(dataset: Dataset, values: Values, T_base_flange: Array, perturb: Perturbation) -> Array:
    """Move of each residual with its own pixel's u and v, one candidate, (m, 3, 2) [m/px].

    Where points come from images of a board, the known place of a row is its very pixel carried to the board by the
    homography, so it moves with the noise too. For all pixels both stay on one viewing ray o + λ r, the known place
    where the ray meets the board (λ_b), the predicted one where it meets the laser plane (λ_s): the residual is
    (λ_b − λ_s) r, and near the optimum, where λ_b ≈ λ_s, its derivative is r (∂λ_b − ∂λ_s). The board is z = 0 of
    the target's frame where the parameters place it, else the plane through all target points.
    """
    pixel = dataset.points["pixel"]

    chain = cast("Perturbation", ChainRule.of(perturb, np.full(2, PIXEL_STEP_PX)))
    at: Any = Dual(pixel[None], np.broadcast_to(np.eye(2)[:, None, None], (2, 1, *pixel.shape)), (0, 1))
    seen: Any = scanner_geometry.in_base(dataset, values, T_base_flange, chain, pixel=at)[0]
    if dataset.board is None:
        return np.asarray(-np.moveaxis(seen.slopes, 0, -1))

    centre = (T_base_flange @ scanner_geometry.mount(dataset, values, perturb))[0, :, :3, 3]
    centre = np.broadcast_to(centre, (len(dataset.poses), 3))[dataset.points.pose]
    if dataset.placed:
        known = scanner_geometry.target(dataset, values, perturb)[0]
        origin, normal = known.mean(axis=0), np.linalg.svd(known - known.mean(axis=0), full_matrices=False)[2][2]
    else:
        T_base_target = motion(values, "target")[0]
        origin, normal = T_base_target[:3, 3], T_base_target[:3, 2]

    along = seen - centre
    to_plane = np.linalg.norm(along, axis=-1, keepdims=True)
    ray = along / to_plane
    gap: Any = ((origin - centre) @ normal)[:, None] / (ray @ normal)[:, None] - to_plane
    return np.asarray(bare(ray)[:, :, None] * np.moveaxis(gap.slopes, 0, -1))


def board_errors(board: Board, points: Points, T_base_target: Array, m_per_px: Array) -> ErrorSource:
    """`board` [px], of each corner along x and y of the board, shared by all rows of an image.

    Where rows come from images of a board, a homography through its corners says where on the board each pixel lies.
    It errs as the corners do, alike for all rows: without this source the rows, being many, would seem to know the
    board's place from each pose better than its corners do.

    Args:
        board: Its corners.
        points: The rows, in the board's frame.
        T_base_target: The board's frame.
        m_per_px: What a pixel sees where each row is, (m,).
    """
    last = np.array([board.columns - 1, board.rows - 1])
    steps = [np.arange(end + 1) - end / 2 for end in last]
    corners = _homographies(np.stack(np.meshgrid(*steps), axis=-1).reshape(-1, 2))
    of_unit_error = np.linalg.inv(np.linalg.qr(corners.reshape(-1, 8)).R)
    on_board = _homographies(points["xyz"][:, :2] / board.square_m - last / 2) @ of_unit_error
    effect = m_per_px[:, None, None] * (T_base_target[:3, :2] @ on_board)
    return ErrorSource("board", effect, points.pose, "px", level="point", most=LARGEST_PX)


def _homographies(at: Array) -> Array:
    """Small motions of points (m, 2) by each of a homography's eight numbers, (m, 2, 8)."""
    x, y = at.T
    one, none = np.ones_like(x), np.zeros_like(x)
    along_x = np.stack([one, none, x, y, none, none, x * x, x * y], axis=-1)
    along_y = np.stack([none, one, none, none, x, y, x * y, y * y], axis=-1)
    return np.stack([along_x, along_y], axis=1)
