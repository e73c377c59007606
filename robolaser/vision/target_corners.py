"""From images to the points of a target: which pixels show which corners or circles of a board."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from typing import final

import numpy as np

from robolaser.arrays import Array, Bools, Progress
from robolaser.data.board import Board
from robolaser.data.dataset import Dataset, Points
from robolaser.data.image_list import images_of_poses, repeat_columns
from robolaser.errors import ImageError
from robolaser.vision.board import Image, find_board
from robolaser.vision.board_orientation import orient_by_continuity, orient_by_robot
from robolaser.vision.charuco import find_charuco
from robolaser.vision.circle_grid import find_circles, lattice
from robolaser.vision.images import read_grey
from robolaser.vision.lens import find_lens, view_board

FEWEST = 4  # corners of which an image must show at least so many: fewer say nothing of where the board stands
ENOUGH = 8  # corners from which an image helps to find the lens, and is told how well it fits the pattern
MOST_TURNS = 2  # ways to lay the frame on a target: of more it is not known which is the same from image to image


@final
@dataclass(frozen=True)
class SeenTarget:
    """What became of one image."""

    pose: str  # the pose it was taken at
    points: int  # corners or circles that were found
    rms_px: float  # of these against the target's pattern; NaN where that was not looked at


@final
@dataclass(frozen=True)
class _Found:
    pose: str
    repeat: int
    ways: tuple[Array, ...]


def points_of_target(recording: Dataset, progress: Progress | None = None) -> tuple[list[SeenTarget], Dataset]:
    """Find the target in every image.

    Args:
        recording: A data set on disk with [board], [image] and a column `image` in poses.csv.
        progress: Called with what is being done and the share that is done.

    Returns:
        A word on each image, and the data set with the points; images without the target have none.

    Raises:
        DataError: poses.csv does not name the first image of a pose, or a path leaves the folder.
        ImageError: The recording has no board or images; an image is missing, broken or of another size; the target is
            in none; it looks the same from more sides than can be told apart.
    """
    board, size, shots = recording.board, recording.image_px, images_of_poses(recording)
    if board is None or size is None:
        raise ImageError("There are no points to extract: dataset.toml has no [board] with columns, rows and square_m.")
    if not shots:
        raise ImageError("There are no points to extract: poses.csv has no column 'image' with images.")
    images = [(one.pose, number, path) for one in shots for number, path in enumerate(one.lit, start=1)]

    def look(wanted: Board, *, staggered: bool = False) -> list[_Found]:
        found = []
        for done, (pose, number, path) in enumerate(images, start=1):
            found.append(_Found(pose, number, target_in(read_grey(path, *size), wanted, staggered=staggered)))
            if progress is not None:
                progress("looking at images", done / len(images))
        return found

    staggered, found = False, look(board)
    if board.kind == "circles":
        other = look(board, staggered=True)
        if sum(bool(one.ways) for one in other) > sum(bool(one.ways) for one in found):
            staggered, found = True, other
    if not any(one.ways for one in found):
        raise _never_seen(board, look(replace(board, columns=board.rows, rows=board.columns)), len(images))
    return _as_points(recording, board, found, staggered=staggered)


def target_in(image: Image, board: Board, *, staggered: bool = False) -> tuple[Array, ...]:
    """Every way to lay the frame on the target, (rows, columns, 2) [px] each; () where it is not seen."""
    if board.kind == "charuco":
        grid = find_charuco(image, board)
        ways: tuple[Array, ...] = () if grid is None else (grid,)
    elif board.kind in ("circles", "modified_circles"):
        ways = find_circles(image, board, staggered=staggered)
    else:
        seen = find_board(image, columns=board.columns, rows=board.rows)
        ways = () if seen is None else seen.orientations
    return tuple(way for way in ways if _is_telling(_there(way)))


def _there(grid: Array) -> Bools:
    return np.asarray(np.isfinite(grid).all(axis=-1))


def _is_telling(there: Bools) -> bool:
    """Whether the corners that are seen, (rows, columns), are enough and not all in one line."""
    return bool(there.sum() >= FEWEST and there.any(axis=0).sum() > 1 and there.any(axis=1).sum() > 1)


def _never_seen(board: Board, turned: Sequence[_Found], images: int) -> ImageError:
    what, nodes = {
        "checkerboard": ("a checkerboard", "inner corners"),
        "charuco": ("a ChArUco board", "inner corners"),
        "circles": ("a grid of circles", "circles"),
        "modified_circles": ("a grid of circles, one of them larger,", "circles"),
    }[board.kind]
    count = sum(bool(one.ways) for one in turned)
    if count and board.columns != board.rows:
        return ImageError(
            f"None of {images} images shows {what} of {board.columns} x {board.rows} {nodes}, but {count} show one of"
            f" {board.rows} x {board.columns}: exchange columns and rows under [board]."
        )
    return ImageError(
        f"None of {images} images shows {what} of {board.columns} x {board.rows} {nodes}. Check columns and rows under"
        f" [board] ({nodes}, not squares){', dictionary' if board.kind == 'charuco' else ''}, and the exposure."
    )


def _as_points(
    recording: Dataset, board: Board, found: Sequence[_Found], *, staggered: bool
) -> tuple[list[SeenTarget], Dataset]:
    seen = [one for one in found if one.ways]
    if max(len(one.ways) for one in seen) > MOST_TURNS:
        raise ImageError(
            f"The target of {board.columns} x {board.rows} looks the same after every quarter turn, so it"
            " is not known which point is which from image to image. Use a ChArUco board, or one with different"
            " numbers of columns and rows."
        )
    grids = _settled(recording, board, seen, staggered=staggered)
    there = [_there(grid) for grid in grids]
    rms = dict.fromkeys(range(len(seen)), float("nan"))
    if not staggered:
        lens = find_lens(
            [grid for grid, one in zip(grids, there, strict=True) if one.sum() >= ENOUGH],
            board.square_m,
            *_size(recording),
        )
        whole = [i for i, one in enumerate(there) if one.sum() >= ENOUGH]
        rms |= {i: view_board(grids[i], board.square_m, lens).corner_rms_px for i in whole}
    number = {name: i for i, name in enumerate(recording.poses.names)}
    place = _places(board, staggered=staggered)
    rows, columns = (np.asarray(each) for each in np.indices(place.shape[:2]))
    counts = [int(one.sum()) for one in there]
    names = [f"{column}_{row}" for one in there for column, row in zip(columns[one], rows[one], strict=True)]
    points = Points(
        pose=np.repeat([number[one.pose] for one in seen], counts),
        names=tuple(names),
        repeat=np.repeat([one.repeat for one in seen], counts) if repeat_columns(recording.poses) else None,
        pixel=np.concatenate([grid[one] for grid, one in zip(grids, there, strict=True)]),
        xyz=np.concatenate([place[one] for one in there]),
    )
    seen_by_id = {id(one): SeenTarget(one.pose, counts[i], rms[i]) for i, one in enumerate(seen)}
    per_image = [seen_by_id.get(id(one), SeenTarget(one.pose, 0, float("nan"))) for one in found]
    return per_image, replace(recording, points=points)


def _settled(recording: Dataset, board: Board, seen: Sequence[_Found], *, staggered: bool) -> list[Array]:
    """One way to lay the frame on the target through all images, (rows, columns, 2) [px] each."""
    ways = [one.ways for one in seen]
    if all(len(each) == 1 for each in ways):
        return [each[0] for each in ways]
    lens = find_lens([each[0] for each in ways], board.square_m, *_size(recording))
    if staggered or not lens.known:
        return orient_by_continuity(ways)
    turns: Mapping[str, Array] = dict(zip(recording.poses.names, recording.flange()[:, :3, :3], strict=True))
    return orient_by_robot(ways, np.stack([turns[one.pose] for one in seen]), lens)


def _size(recording: Dataset) -> tuple[int, int]:
    assert recording.image_px is not None  # was asked for before any image
    return recording.image_px


def _places(board: Board, *, staggered: bool) -> Array:
    """The target's points in its own frame, (rows, columns, 3) [m]."""
    places = lattice(board.columns, board.rows, staggered=staggered)
    return np.asarray(board.square_m * np.pad(places, ((0, 0), (0, 0), (0, 1))))
