"""A target in an image: a checkerboard, a ChArUco board whose markers name its corners, or a grid of circles."""

from functools import cache

import cv2
import numpy as np

from robolaser.arrays import Array, Bools, Image
from robolaser.data.board import Board, dictionary, lattice
from robolaser.vision.board import LARGEST_UNEVENNESS, find_board, off_pattern, quarter_turns, sharpened

WINDOW_PX = (2, 8)  # half sides of the window for the refinement of a ChArUco board's corner, least and most
LARGER = 1.15  # least diameter over the usual one of the circle that marks the origin


def target_in(image: Image, board: Board) -> tuple[Array, ...]:
    """All possible frames of the target in a grey image, (rows, columns, 2) [px] each; () where it is not visible.

    Raises:
        DataError: OpenCV has no dictionary of that name.
    """
    if board.kind == "charuco":
        grid = _charuco(image, board)
        ways: tuple[Array, ...] = () if grid is None else (grid,)
    elif board.kind in ("circles", "modified_circles"):
        ways = _circles(image, board)
    else:
        seen = find_board(image, columns=board.columns, rows=board.rows)
        ways = () if seen is None else seen.orientations
    return tuple(way for way in ways if is_telling(corners_there(way)))


def corners_there(grid: Array) -> Bools:
    """Whether each corner of a grid, (..., 2), is seen, (...)."""
    return np.asarray(np.isfinite(grid).all(axis=-1))


def is_telling(there: Bools) -> bool:
    """Whether the visible corners, (rows, columns), determine a perspective: one alone keeps each where it is."""
    xy1 = np.pad(np.argwhere(there), ((0, 0), (0, 1)), constant_values=1)
    moved = np.cross(np.eye(3), xy1[:, None])  # by each entry of a perspective H, in (xy1) x (H xy1) = 0
    return bool(np.linalg.matrix_rank((moved[..., None] * xy1[:, None, None]).reshape(-1, 9)) == 8)


def _charuco(image: Image, board: Board) -> Array | None:
    """Corners by their names, (rows, columns, 2) [px] as (u, v), NaN where one is not visible; None where none is.

    Boards of OpenCV before 4.6, with a light first square where their rows are even, are read too.
    """
    seen = [_seen(image, board, legacy=legacy) for legacy in (False, True)]
    grid = max(seen, key=lambda one: np.isfinite(one).sum())
    return grid if np.isfinite(grid).any() else None


def _sharpened(image: Image, grid: Array, board: Board) -> Array:
    """The corners refined to crossings of the squares' edges, in windows that exclude the markers."""
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
    # The origin's outward diagonal square is dark: with a light first square, the last corner's may be.
    first_is_light = legacy and board.rows % 2 == 1
    return grid[::-1, ::-1] if first_is_light and board.columns % 2 == 0 else grid


def _circles(image: Image, board: Board) -> tuple[Array, ...]:
    """Centres of the circles, dark or light, (rows, columns, 2) [px] as (u, v), once for each possible frame."""
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
    """Whether the circles agree with a plane's perspective, and are not a false combination."""
    rows, columns = grid.shape[:2]
    places, pixel = lattice(columns, rows).reshape(-1, 2), grid.reshape(-1, 2)
    H, _ = cv2.findHomography(places, pixel)
    if np.shape(H) != (3, 3):
        return False
    pitch = float(np.median(np.linalg.norm(np.diff(grid, axis=0), axis=-1)))
    return bool(off_pattern(H, places, pixel).max() <= LARGEST_UNEVENNESS * pitch)


def _from_the_largest(ways: tuple[Array, ...], ground: Image) -> tuple[Array, ...]:
    """The frame whose first circle is larger than the others; () where there is none."""
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
    """All rotations of a grid in its plane after which it looks the same, right-handed with z into the board."""
    x, y = grid[0, -1] - grid[0, 0], grid[-1, 0] - grid[0, 0]
    if x[0] * y[1] - x[1] * y[0] < 0:
        grid = grid[:, ::-1]
    return quarter_turns(grid)
