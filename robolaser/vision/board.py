"""A checkerboard in an image: its inner corners, in the order of the board's own frame."""

from collections.abc import Iterator

import cv2
import numpy as np
from numpy.typing import NDArray

from robolaser.arrays import Array, Bools

Image = NDArray[np.uint8]

WIDEST_SEARCHED_PX = (640, 450, 320, 1280)
"""Long sides [px] of the reduced images that are searched: few pixels blur the stripe and dirt away."""
CELL_PX = 8
"""Side [px] of a square in the image straightened to look at the squares' colours."""
LEAST_ALTERNATING = 0.9
"""Share of squares that must differ from their neighbours as a checkerboard's do; a stripe may hide some."""
LARGEST_UNEVENNESS = 0.15
"""Corners off a plane's perspective, RMS [squares]: beyond any lens, within a false grid's disorder."""
_SEARCH = cv2.CALIB_CB_ADAPTIVE_THRESH | cv2.CALIB_CB_NORMALIZE_IMAGE


def find_board(image: Image, *, columns: int, rows: int) -> tuple[Array, ...]:
    """Find a board's inner corners, to a fraction of a pixel.

    x runs along the columns, y along the rows, z into the board, the origin is a corner whose outward
    diagonal square is dark. Some patterns look the same after a half or quarter turn: then each way to lay
    the frame is given. (Where no corner has a dark square outside it, the colours choose nothing.)

    Args:
        image: Grey image, (height, width).
        columns: Inner corners along the board's x.
        rows: Inner corners along the board's y.

    Returns:
        One grid of corners for each way to lay the frame, (rows, columns, 2) [px] as (u, v), the first
        with its x nearest to image u; none where no board is seen.
    """
    for reduced, scale in _reductions(image):
        found, corners = cv2.findChessboardCorners(reduced, (columns, rows), flags=_SEARCH)
        if not found:
            continue
        grid = (np.asarray(corners, dtype=np.float64).reshape(rows, columns, 2) + 0.5) / scale - 0.5
        grid = _sharpen(image, grid)
        shades = _shades(image, grid)
        if _is_even(grid) and _alternates(shades):
            return _layings(grid, shades)
    return ()


def heading(grid: Array) -> complex:
    """Direction of the board's x in the image, as u + iv."""
    across = np.mean(grid[:, -1] - grid[:, 0], axis=0)
    return complex(across[0], across[1])


def _reductions(image: Image) -> Iterator[tuple[Image, float]]:
    """Give the image reduced by several scales, as it is and with its contrast spread below the stripe."""
    sample = image[::4, ::4]
    dark, light = np.percentile(sample, (1, 90))
    gain = 255.0 / max(1.2 * light - dark, 8.0)
    spread = cv2.convertScaleAbs(np.maximum(image, int(dark)), alpha=gain, beta=-gain * int(dark))
    longest = max(image.shape)
    for source in (image, spread):
        for widest in WIDEST_SEARCHED_PX:
            scale = min(1.0, widest / longest)
            if scale == 1.0 and widest != max(WIDEST_SEARCHED_PX):
                continue
            size = (round(image.shape[1] * scale), round(image.shape[0] * scale))
            yield np.asarray(cv2.resize(source, size, interpolation=cv2.INTER_AREA), np.uint8), scale


def _sharpen(image: Image, grid: Array) -> Array:
    rows, columns = grid.shape[:2]
    spacing = min(
        np.linalg.norm(np.diff(grid, axis=0), axis=-1).min(), np.linalg.norm(np.diff(grid, axis=1), axis=-1).min()
    )
    half = int(np.clip(spacing / 4, 2, 11))
    stop = (cv2.TERM_CRITERIA_EPS | cv2.TERM_CRITERIA_MAX_ITER, 60, 1e-3)
    start = grid.reshape(-1, 1, 2).astype(np.float32)
    fine = cv2.cornerSubPix(image, start, (half, half), (-1, -1), stop)
    return np.asarray(fine, dtype=np.float64).reshape(rows, columns, 2)


def _lattice(columns: int, rows: int) -> Array:
    """Corners in squares, (rows, columns, 2)."""
    return np.stack(np.meshgrid(np.arange(columns), np.arange(rows)), axis=-1).astype(np.float64)


def _is_even(grid: Array) -> bool:
    rows, columns = grid.shape[:2]
    lattice = _lattice(columns, rows).reshape(-1, 2)
    H, _ = cv2.findHomography(grid.reshape(-1, 2), lattice)
    if np.shape(H) != (3, 3):
        return False
    off = cv2.perspectiveTransform(grid.reshape(-1, 1, 2), H).reshape(-1, 2) - lattice
    return bool(np.sqrt(np.mean(np.sum(off**2, axis=-1))) < LARGEST_UNEVENNESS)


def _shades(image: Image, grid: Array) -> Array:
    """Mean grey of the squares between the corners, (rows - 1, columns - 1)."""
    rows, columns = grid.shape[:2]
    cells = _lattice(columns, rows).reshape(-1, 2) * CELL_PX - 0.5
    H, _ = cv2.findHomography(grid.reshape(-1, 2), cells)
    size = ((columns - 1) * CELL_PX, (rows - 1) * CELL_PX)
    straight = np.asarray(cv2.warpPerspective(image, H, size), dtype=np.float64)
    squares = straight.reshape(rows - 1, CELL_PX, columns - 1, CELL_PX)
    core = slice(CELL_PX // 4, CELL_PX - CELL_PX // 4)
    return np.asarray(squares[:, core, :, core].mean(axis=(1, 3)))


def _alternates(shades: Array) -> bool:
    even = _even(shades.shape)
    down = np.where(even[:-1], 1, -1) * np.sign(np.diff(shades, axis=0))
    right = np.where(even[:, :-1], 1, -1) * np.sign(np.diff(shades, axis=1))
    return bool(abs(down.sum() + right.sum()) >= (2 * LEAST_ALTERNATING - 1) * (down.size + right.size))


def _even(shape: tuple[int, ...]) -> Bools:
    """Squares of the colour of the first, in a checkerboard of this shape."""
    j, i = np.indices(shape)
    return np.asarray((i + j) % 2 == 0)


def _layings(grid: Array, shades: Array) -> tuple[Array, ...]:
    """Turn a found grid into each frame that the contract allows; they differ by turns in the plane."""
    x, y = grid[0, -1] - grid[0, 0], grid[-1, 0] - grid[0, 0]
    if x[0] * y[1] - x[1] * y[0] < 0:
        grid, shades = grid[:, ::-1], shades[:, ::-1]
    quarter = 1 if grid.shape[0] == grid.shape[1] else 2
    turns = [(np.rot90(grid, k), np.rot90(shades, k)) for k in range(0, 4, quarter)]
    dark = [turned for turned, tone in turns if _starts_dark(tone)]
    layings = dark or [turned for turned, _ in turns]
    return tuple(sorted((np.ascontiguousarray(one) for one in layings), key=lambda g: abs(np.angle(heading(g)))))


def _starts_dark(shades: Array) -> bool:
    """Whether the square inward of the origin, and so the one outward across the corner, is dark."""
    even = _even(shades.shape)
    return bool(np.median(shades[even]) < np.median(shades[~even]))
