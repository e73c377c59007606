"""A checkerboard in an image: its inner corners, in the order of the board's own frame."""

from collections.abc import Iterator
from dataclasses import dataclass
from typing import Any, final

import cv2
import numpy as np

from robolaser.arrays import Array, Bools, Image
from robolaser.data.board import lattice

SEARCHED_PX = (640, 450, 320)  # long sides of the reduced images for the search, which blur stripe and dirt
SMALLEST_PX = 24  # least short side of an image for the search: smaller ones have no neighbourhoods
STRIPE_SHARES = (1 / 40, 1 / 20)  # of the longer side: widths of a stripe across squares that is removed
WINDOW_PX = (2, 12)  # half sides of the window in which a corner is sharpened, least and most
GLARE = 1.3  # least grey of the stripe relative to the image's light parts
CELL_PX = 8  # side [px] of a square in the rectified image, for the squares' colours
LEAST_ALTERNATING = 0.8  # share of squares that alternate with their neighbours; a stripe may hide some
LARGEST_UNEVENNESS = 0.15  # median, from a perspective [squares]: more than by any lens, less than in a false grid
STRAY_MEDIANS = 6.0  # distance from the perspective, in medians, of a corner that the stripe has shifted
STRAY_LEAST_PX = 0.7  # least such distance [px]
LEAST_ON_PATTERN = 0.6  # least share of corners that are kept; a median needs more than half
_SEARCH = cv2.CALIB_CB_ADAPTIVE_THRESH | cv2.CALIB_CB_NORMALIZE_IMAGE


@final
@dataclass(frozen=True)
class BoardCorners:
    """A checkerboard in one image."""

    # One grid of corners for each frame that the colours allow, (rows, columns, 2) [px] as (u, v), the first with its
    # x nearest to image u. Hidden corners are NaN.
    orientations: tuple[Array, ...]
    white_level: float  # grey of the light squares away from the stripe


def find_board(image: Image, *, columns: int, rows: int) -> BoardCorners | None:
    """Find a board's inner corners in a grey image, to a fraction of a pixel; None if it is not visible.

    x runs along the columns, y along the rows, z into the board, the origin is a corner whose outward
    diagonal square is dark. Some patterns look the same after a half or quarter turn: then each possible
    frame is returned. (Where no corner has a dark square outside it, all frames are possible.)
    """
    for reduced, scale in _reductions(image):
        found, corners = cv2.findChessboardCorners(reduced, (columns, rows), flags=_SEARCH)
        if not found:
            continue
        grid = (np.asarray(corners, dtype=np.float64).reshape(rows, columns, 2) + 0.5) / scale - 0.5
        spacing = min(np.linalg.norm(np.diff(grid, axis=axis), axis=-1).min() for axis in (0, 1))
        grid = sharpened(image, grid, int(np.clip(spacing / 3, *WINDOW_PX)))
        H_lattice_pixel, on_pattern = _pattern(grid)
        if on_pattern.mean() < LEAST_ON_PATTERN:
            continue
        shades = _shades(image, H_lattice_pixel, columns, rows)
        if _alternates(shades):
            even = _even(shades.shape)
            white_level = float(max(np.median(shades[even]), np.median(shades[~even])))
            return BoardCorners(_orientations(np.where(on_pattern[..., None], grid, np.nan), shades), white_level)
    return None


def heading(grid: Array) -> complex:
    """Direction of the board's x in the image, as u + iv."""
    x = _pitch(grid, 1)
    return complex(x[0], x[1])


def off_pattern(H_pixel_board: Any, places: Array, pixel: Array) -> Array:
    """Distance of pixels from the projections of their positions on the board, both (n, 2), (n,) [px]."""
    shown = np.asarray(cv2.perspectiveTransform(places.reshape(-1, 1, 2), H_pixel_board)).reshape(-1, 2)
    return np.asarray(np.linalg.norm(shown - pixel, axis=-1))


def sharpened(image: Image, pixel: Array, half: int) -> Array:
    """Refine corners, (..., 2), to crossings of edges in a window of so many pixels on either side, (..., 2)."""
    stop = (cv2.TERM_CRITERIA_EPS | cv2.TERM_CRITERIA_MAX_ITER, 60, 1e-3)
    fine = cv2.cornerSubPix(image, pixel.reshape(-1, 1, 2).astype(np.float32), (half, half), (-1, -1), stop)
    return np.asarray(fine, dtype=np.float64).reshape(pixel.shape)


def quarter_turns(grid: Array) -> tuple[Array, ...]:
    """All rotations of a grid in its plane that keep its columns and rows, (rows, columns, ...) each."""
    quarter = 1 if grid.shape[0] == grid.shape[1] else 2
    return tuple(np.ascontiguousarray(np.rot90(grid, k)) for k in range(0, 4, quarter))


def _pitch(grid: Array, axis: int) -> Array:
    """Typical step from a corner to the next, (2,) [px]."""
    steps = np.diff(grid, axis=axis).reshape(-1, 2)
    return np.asarray(np.median(steps[np.isfinite(steps).all(axis=-1)], axis=0))


def _reductions(image: Image) -> Iterator[tuple[Image, float]]:
    """Yield the image at several scales: unchanged, without stripe, and with enhanced contrast."""
    dark, light = np.percentile(image[::4, ::4], (1, 90))
    gain = 255.0 / max(1.2 * light - dark, 8.0)
    spread = cv2.convertScaleAbs(np.maximum(image, int(dark)), alpha=gain, beta=-gain * int(dark))
    for source in (image, *_wiped(image, float(light)), spread):
        for side in SEARCHED_PX:
            scale = min(1.0, side / max(image.shape))
            size = (round(image.shape[1] * scale), round(image.shape[0] * scale))
            if min(size) >= SMALLEST_PX:
                yield np.asarray(cv2.resize(source, size, interpolation=cv2.INTER_AREA), np.uint8), scale
    if max(image.shape) > max(SEARCHED_PX) and min(image.shape) >= SMALLEST_PX:
        yield image, 1.0


def _wiped(image: Image, light: float) -> Iterator[Image]:
    """The image with bright narrow light replaced by its surroundings, across either axis."""
    bright = (image > GLARE * light).astype(np.uint8)
    glare = np.asarray(cv2.dilate(bright, np.ones((5, 5), np.uint8))) > 0
    for share in STRIPE_SHARES:
        breadth = max(1, round(share * max(image.shape)))
        for kernel in (np.ones((1, breadth), np.uint8), np.ones((breadth, 1), np.uint8)):
            yield np.where(glare, cv2.morphologyEx(image, cv2.MORPH_OPEN, kernel), image).astype(np.uint8)


def _pattern(grid: Array) -> tuple[Array, Bools]:
    """Find the perspective of most corners, (3, 3) from pixels to squares, and its inliers, (rows, columns)."""
    rows, columns = grid.shape[:2]
    squares = lattice(columns, rows).reshape(-1, 2)
    pixel = grid.reshape(-1, 2)
    square_px = min(np.linalg.norm(_pitch(grid, 0)), np.linalg.norm(_pitch(grid, 1)))
    near = np.zeros(len(pixel), dtype=np.bool_)
    H, _ = cv2.findHomography(squares, pixel, cv2.LMEDS)
    if np.shape(H) != (3, 3):
        return np.eye(3), near.reshape(rows, columns)
    for _ in range(3):
        off = off_pattern(H, squares, pixel)
        typical = float(np.median(off))
        near = (off <= max(STRAY_MEDIANS * typical, STRAY_LEAST_PX)) & (typical <= LARGEST_UNEVENNESS * square_px)
        if near.mean() < LEAST_ON_PATTERN:
            break
        H, _ = cv2.findHomography(squares[near], pixel[near])
    return np.asarray(np.linalg.inv(H)), near.reshape(rows, columns)


def _shades(image: Image, H_lattice_pixel: Array, columns: int, rows: int) -> Array:
    """Median grey of the squares between the corners, (rows - 1, columns - 1)."""
    half = 0.5 / CELL_PX
    into_cells = CELL_PX * np.array([[1, 0, -half], [0, 1, -half], [0, 0, 1 / CELL_PX]])
    size = ((columns - 1) * CELL_PX, (rows - 1) * CELL_PX)
    straight = np.asarray(cv2.warpPerspective(image, into_cells @ H_lattice_pixel, size), dtype=np.float64)
    squares = straight.reshape(rows - 1, CELL_PX, columns - 1, CELL_PX)
    core = slice(CELL_PX // 4, CELL_PX - CELL_PX // 4)
    return np.asarray(np.median(squares[:, core, :, core], axis=(1, 3)))


def _alternates(shades: Array) -> bool:
    even = _even(shades.shape)
    down = np.where(even[:-1], 1, -1) * np.sign(np.diff(shades, axis=0))
    right = np.where(even[:, :-1], 1, -1) * np.sign(np.diff(shades, axis=1))
    return bool(abs(down.sum() + right.sum()) >= (2 * LEAST_ALTERNATING - 1) * (down.size + right.size))


def _even(shape: tuple[int, ...]) -> Bools:
    """Squares with the colour of the first, in a checkerboard of this shape."""
    j, i = np.indices(shape)
    return np.asarray((i + j) % 2 == 0)


def _orientations(grid: Array, shades: Array) -> tuple[Array, ...]:
    """Rotate a grid into each allowed frame; these differ by rotations in the plane."""
    x, y = _pitch(grid, 1), _pitch(grid, 0)
    if x[0] * y[1] - x[1] * y[0] < 0:
        grid, shades = grid[:, ::-1], shades[:, ::-1]
    ways = quarter_turns(grid)
    dark = [way for way, tones in zip(ways, quarter_turns(shades), strict=True) if _starts_dark(tones)]
    return tuple(sorted(dark or ways, key=lambda way: abs(np.angle(heading(way)))))


def _starts_dark(shades: Array) -> bool:
    """Whether the square inside the origin, and so the one outside across the corner, is dark."""
    even = _even(shades.shape)
    return bool(np.median(shades[even]) < np.median(shades[~even]))
