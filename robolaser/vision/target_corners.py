"""From images to the points of a target: pixels of the corners or circles of a board."""

from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import Any, final

import numpy as np

from robolaser.arrays import Array, Progress
from robolaser.data.board import Board
from robolaser.data.dataset import Dataset, Points
from robolaser.data.image_list import images_of_poses, repeat_columns
from robolaser.errors import ImageError
from robolaser.vision.board_orientation import oriented
from robolaser.vision.images import CameraImages
from robolaser.vision.lens import find_lens, view_board
from robolaser.vision.target import corners_there, target_in

ENOUGH = 8  # least corners of an image for the lens, and for a misfit against the pattern


@final
@dataclass(frozen=True)
class Frame:
    """The result for one image, or, for a stripe, the images of one pose."""

    pose: str  # its name
    skipped: str = ""  # reason why they have no points; empty if they have
    points: int = 0  # number of points
    corner_rms_px: float = float("nan")  # RMS distance of corners or circles from the pattern [px]; NaN: not computed
    line_rms_px: float = float("nan")  # RMS of the stripe's kept lines about a straight one [px]; NaN without a stripe
    beside: bool = False  # whether the stripe crosses no square of the board: it is assumed on the board's plane
    left_out: float = 0.0  # share of the stripe's lines of pixels beyond a step beside the squares, on another surface


@final
@dataclass(frozen=True)
class _Found:
    row: int  # of poses.csv
    repeat: int
    ways: tuple[Array, ...]


def points_of_target(
    recording: Dataset, *, progress: Progress | None = None, known: dict[object, Any] | None = None
) -> tuple[list[Frame], Dataset]:
    """Detect the target in every image.

    The recording has [board], [image] and a column `image` in poses.csv. Detections are added to those known: no image
    is searched twice.

    Returns:
        The result for each image, and the data set with the points; images without the target have none.

    Raises:
        DataError: poses.csv does not name the first image of a pose, or a path leaves the folder.
        ImageError: The recording has no board or images; an image is missing, broken or of another size; the target is
            in none; it has more symmetries than the images can distinguish.
    """
    board, size, shots = recording.board, recording.image_px, images_of_poses(recording)
    if board is None or size is None:
        raise no_points("dataset.toml has no [board] with columns, rows and square_m")
    if not shots:
        raise no_points("poses.csv has no column 'image' with images")
    images = [(one.row, number, path) for one in shots for number, path in enumerate(one.lit, start=1)]
    camera = CameraImages.of((path for _, _, path in images), size)
    known = {} if known is None else known

    found = []
    for done, (row, number, path) in enumerate(images, start=1):
        key = path, camera, board
        if key not in known:
            known[key] = target_in(camera.grey(path), board)
        found.append(_Found(row, number, known[key]))
        if progress is not None:
            progress("looking at images", done / len(images))
    if not any(one.ways for one in found):
        raise _never_seen(board, len(images))
    return _as_points(recording, board, found)


def no_points(reason: str) -> ImageError:
    """The error of a recording whose images cannot give points."""
    return ImageError(f"There are no points to extract: {reason}.")


def _never_seen(board: Board, images: int) -> ImageError:
    what, nodes = {
        "checkerboard": ("a checkerboard", "inner corners"),
        "charuco": ("a ChArUco board", "inner corners"),
        "circles": ("a grid of circles", "circles"),
        "modified_circles": ("a grid of circles, one of them larger,", "circles"),
    }[board.kind]
    return ImageError(
        f"None of {images} images shows {what} of {board.columns} x {board.rows} {nodes}. Check the exposure and, under"
        f" [board], columns and rows ({nodes}, not squares; not exchanged)"
        f"{' and dictionary' * (board.kind == 'charuco')}."
    )


def _as_points(recording: Dataset, board: Board, found: Sequence[_Found]) -> tuple[list[Frame], Dataset]:
    seen = [one for one in found if one.ways]
    assert recording.image_px is not None  # was checked before any image
    whole = [one.ways[0] for one in seen if corners_there(one.ways[0]).sum() >= ENOUGH]
    lens = find_lens(whole, board.square_m, *recording.image_px)
    turns = recording.flange()[[one.row for one in seen], :3, :3]
    grids, is_certain = oriented([one.ways for one in seen], turns, lens)
    if not is_certain:
        raise ImageError(
            f"The target of {board.columns} x {board.rows} looks the same after every quarter turn, and the poses of"
            " the flange do not show which point is which from image to image. Use a ChArUco board, or one with"
            " different numbers of columns and rows; or tilt and turn the flange more."
        )
    points = corner_points(board, [one.row for one in seen], grids)
    counts = [int(corners_there(grid).sum()) for grid in grids]
    if repeat_columns(recording.poses):
        points = replace(points, repeat=np.repeat([one.repeat for one in seen], counts))
    judged = [
        view_board(grid, board.square_m, lens).corner_rms_px if count >= ENOUGH else float("nan")
        for grid, count in zip(grids, counts, strict=True)
    ]
    each, names = iter(zip(counts, judged, strict=True)), recording.poses.names
    frames = [Frame(names[one.row], *(("", *next(each)) if one.ways else ("no target",))) for one in found]
    return frames, replace(recording, points=points)


def corner_points(board: Board, poses: Sequence[int], grids: Sequence[Array]) -> Points:
    """The corners or circles in images as points of a data set, named by column and row: `3_0`.

    Of each image the row of poses.csv, and the pixels, (rows, columns, 2); NaN where one is hidden.
    """
    pixel = np.reshape(grids, (-1, board.rows, board.columns, 2))
    image, row, column = np.nonzero(corners_there(pixel))
    return Points(
        np.asarray(poses, dtype=np.int64)[image],
        tuple(f"{i}_{j}" for i, j in zip(column.tolist(), row.tolist(), strict=True)),
        pixel=pixel[image, row, column],
        xyz=board.corners[row, column],
    )
