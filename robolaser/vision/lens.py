"""The lens of a recording, and the board's plane in each image."""

from collections.abc import Sequence
from dataclasses import dataclass
from typing import final

import cv2
import numpy as np

from robolaser.arrays import Array
from robolaser.data.board import lattice
from robolaser.geometry.board_views import one_thread
from robolaser.vision.board import off_pattern

FEWEST_VIEWS = 3  # boards from which focal length and distortion are distinguishable
MOST_VIEWS = 40  # boards, spread over the recording, for the lens; more cost much and add little
FREED_SIGMAS = 5.0
"""Standard deviations by which a released parameter must differ from its fixed value.

That many, since a print's errors are the same in all views and make parameters look more certain than they are.
"""
FOCAL_RANGE = (0.3, 30.0)  # focal lengths of lenses [image widths]; a fit outside had too little tilt
STRAY_MEDIANS = 5.0  # distance from the fitted plane, in medians, of a corner that the stripe has shifted
STRAY_LEAST_PX = 0.3  # least such distance [px]
_ALWAYS = cv2.CALIB_USE_INTRINSIC_GUESS | cv2.CALIB_ZERO_TANGENT_DIST | cv2.CALIB_FIX_K3
_CENTRE, _K2 = (2, 3), (5,)  # among OpenCV's intrinsics: fx fy cx cy k1 k2 ...
MODELS: tuple[tuple[int, tuple[int, ...]], ...] = (
    (_ALWAYS | cv2.CALIB_FIX_K2 | cv2.CALIB_FIX_PRINCIPAL_POINT, ()),
    (_ALWAYS | cv2.CALIB_FIX_K2, _CENTRE),
    (_ALWAYS, _K2),
)
"""Lens models from stiff to free, each with the intrinsics that it releases. There are two focal lengths: prints are
often longer in one direction by a few tenths of a per cent."""


@final
@dataclass(frozen=True)
class Intrinsics:
    """A pinhole camera with radial distortion, in OpenCV's form."""

    matrix: Array  # camera matrix, (3, 3) [px]
    distortion: Array  # k1, k2, p1, p2, k3; all zero for an unknown lens
    known: bool  # whether it was estimated from the boards

    def undistort(self, pixel: Array) -> Array:
        """Undistort pixels, (n, 2) -> (n, 2) [px]."""
        if not self.known or len(pixel) == 0:
            return pixel
        distorted = np.ascontiguousarray(pixel, dtype=np.float64).reshape(-1, 1, 2)
        straight = cv2.undistortPoints(distorted, self.matrix, self.distortion, P=self.matrix)
        return np.asarray(straight, dtype=np.float64).reshape(-1, 2)


@final
@dataclass(frozen=True)
class BoardPlane:
    """The board's plane in one image."""

    H_board_pixel: Array  # homography from undistorted pixels to the board's x and y, (3, 3) [m]
    R_camera_board: Array  # rotation of the board in the camera, (3, 3); NaN where the lens is not known
    corner_rms_px: float  # RMS distance of corners from the board's pattern [px]

    def intersect(self, straight: Array) -> Array:
        """Intersect the rays of undistorted pixels, (n, 2), with the board's plane: x and y, (n, 2) [m]."""
        if len(straight) == 0:
            return straight
        xy = cv2.perspectiveTransform(straight.reshape(-1, 1, 2), self.H_board_pixel)
        return np.asarray(xy, dtype=np.float64).reshape(-1, 2)


def _seen(grid: Array, square_m: float) -> tuple[Array, Array]:
    """The visible corners, by position on the board, (n, 2) [m], and pixel, (n, 2)."""
    rows, columns = grid.shape[:2]
    board = square_m * lattice(columns, rows).reshape(-1, 2)
    there = np.isfinite(grid).all(axis=-1).ravel()
    return board[there], grid.reshape(-1, 2)[there]


def find_lens(grids: Sequence[Array], square_m: float, width_px: int, height_px: int) -> Intrinsics:
    """Estimate the lens from all visible boards, (rows, columns, 2) [px] each; NaN where a corner is hidden.

    Returns:
        The lens; not known where the boards are too few or do not determine it.
    """
    guess = np.array([[2.0 * width_px, 0, (width_px - 1) / 2], [0, 2.0 * width_px, (height_px - 1) / 2], [0, 0, 1]])
    unknown = Intrinsics(guess, np.zeros(5), known=False)
    if len(grids) < FEWEST_VIEWS:
        return unknown
    chosen = np.unique(np.linspace(0, len(grids) - 1, min(len(grids), MOST_VIEWS)).astype(np.int64))
    seen = [_seen(grids[i], square_m) for i in chosen]
    boards = [np.pad(board, ((0, 0), (0, 1))).astype(np.float32) for board, _ in seen]
    pixels = [pixel.reshape(-1, 1, 2).astype(np.float32) for _, pixel in seen]
    best = unknown
    for model, freed in MODELS:
        try:
            with one_thread():
                _, matrix, distortion, _, _, doubts, *_ = cv2.calibrateCameraExtended(
                    boards, pixels, (width_px, height_px), guess.copy(), np.zeros(5), flags=model
                )
        except cv2.error:
            continue
        lens = Intrinsics(np.asarray(matrix, float), np.asarray(distortion, float).ravel(), known=True)
        left = np.abs(_intrinsics(lens) - _intrinsics(unknown))[list(freed)]
        surely = not freed or (left > FREED_SIGMAS * doubts.ravel()[list(freed)]).any()
        if FOCAL_RANGE[0] < matrix[0, 0] / width_px < FOCAL_RANGE[1] and surely:
            best = lens
    return best


def _intrinsics(lens: Intrinsics) -> Array:
    """In OpenCV's order, (9,)."""
    K = lens.matrix
    return np.array([K[0, 0], K[1, 1], K[0, 2], K[1, 2], *lens.distortion])


def view_board(grid: Array, square_m: float, lens: Intrinsics) -> BoardPlane:
    """Find the plane of a board in one image from its corners, (rows, columns, 2) [px].

    With a known lens the plane has the six degrees of freedom of a rigid board, which extrapolates beyond the corners
    better than the eight of a homography.
    """
    board, pixel = _seen(grid, square_m)
    straight = lens.undistort(pixel)
    lay = _rigid if lens.known else _loose
    H_pixel_board, R = lay(board, straight, lens)
    off = off_pattern(H_pixel_board, board, straight)
    near = off <= max(STRAY_MEDIANS * float(np.median(off)), STRAY_LEAST_PX)
    if not near.all():
        H_pixel_board, R = lay(board[near], straight[near], lens)
        off = off_pattern(H_pixel_board, board[near], straight[near])
    H_board_pixel = np.asarray(np.linalg.inv(H_pixel_board), dtype=np.float64)
    return BoardPlane(H_board_pixel, R, float(np.sqrt(np.mean(off**2))))


def _loose(board: Array, straight: Array, lens: Intrinsics) -> tuple[Array, Array]:
    return np.asarray(cv2.findHomography(board, straight)[0], dtype=np.float64), np.full_like(lens.matrix, np.nan)


def _rigid(board: Array, straight: Array, lens: Intrinsics) -> tuple[Array, Array]:
    flat = np.pad(board, ((0, 0), (0, 1)))
    pixel = straight.reshape(-1, 1, 2)
    # Not SOLVEPNP_IPPE: by rounding it may give NaN for a board tilted about one of its axes.
    _, turn, shift = cv2.solvePnP(flat, pixel, lens.matrix, None, flags=cv2.SOLVEPNP_ITERATIVE)
    R = np.asarray(cv2.Rodrigues(turn)[0], dtype=np.float64)
    return lens.matrix @ np.column_stack([R[:, 0], R[:, 1], np.ravel(shift)]), R
