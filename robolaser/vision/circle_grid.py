"""A straight grid of circles in an image."""

import cv2
import numpy as np

from robolaser.arrays import Array, Image
from robolaser.data.board import Board, lattice
from robolaser.vision.board import LARGEST_UNEVENNESS, off_pattern, quarter_turns

LARGER = 1.15
"""Times the usual diameter, from which a circle is the one that marks the origin."""


def find_circles(image: Image, board: Board) -> tuple[Array, ...]:
    """Middles of the circles, (rows, columns, 2) [px] as (u, v), once for each way to lay the frame; () where not seen.

    Args:
        image: Grey image, (height, width), dark circles on light ground or the other way round.
        board: Columns and rows of circles.
    """
    for ground in (image, cv2.bitwise_not(image)):
        for clustering in (0, cv2.CALIB_CB_CLUSTERING):
            flags = cv2.CALIB_CB_SYMMETRIC_GRID | clustering
            found, middles = cv2.findCirclesGrid(ground, (board.columns, board.rows), flags=flags)
            if found:
                grid = np.asarray(middles, dtype=np.float64).reshape(board.rows, board.columns, 2)
                if _is_even(grid):
                    ways = _ways(grid)
                    is_marked = board.kind == "modified_circles"
                    return _from_the_largest(ways, np.asarray(ground, dtype=np.uint8)) if is_marked else ways
    return ()


def _is_even(grid: Array) -> bool:
    """Whether the circles lie as a plane's perspective puts them, and were not put together from others."""
    rows, columns = grid.shape[:2]
    places, pixel = lattice(columns, rows).reshape(-1, 2), grid.reshape(-1, 2)
    H, _ = cv2.findHomography(places, pixel)
    if np.shape(H) != (3, 3):
        return False
    pitch = float(np.median(np.linalg.norm(np.diff(grid, axis=0), axis=-1)))
    return bool(off_pattern(H, places, pixel).max() <= LARGEST_UNEVENNESS * pitch)


def _from_the_largest(ways: tuple[Array, ...], ground: Image) -> tuple[Array, ...]:
    """The way that has the circle larger than the others first; () where no circle is."""
    spots = cv2.SimpleBlobDetector.create().detect(ground)
    if not spots:
        return ()
    middles, sizes = np.array([spot.pt for spot in spots]), np.array([spot.size for spot in spots])

    def size_at(grid: Array) -> Array:
        apart = np.linalg.norm(grid.reshape(-1, 1, 2) - middles, axis=-1)
        return np.asarray(sizes[apart.argmin(axis=1)])

    large = size_at(ways[0])
    if large.max() < LARGER * np.median(large):
        return ()
    return (min(ways, key=lambda grid: int(size_at(grid).argmax())),)


def _ways(grid: Array) -> tuple[Array, ...]:
    """Every turn of a grid in its plane after which it looks the same, the frame right-handed with z into the board."""
    x, y = grid[0, -1] - grid[0, 0], grid[-1, 0] - grid[0, 0]
    if x[0] * y[1] - x[1] * y[0] < 0:
        grid = grid[:, ::-1]
    return quarter_turns(grid)
