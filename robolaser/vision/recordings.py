"""A recording is a data set whose points are still in its images."""

from collections.abc import Iterator, Sequence
from dataclasses import replace
from typing import Any

import numpy as np

from robolaser.arrays import Progress
from robolaser.data.dataset import Dataset, Points
from robolaser.data.image_list import PoseImages, images_of_poses, repeat_columns
from robolaser.data.several_sensors import scanner_with_corners, with_points_of
from robolaser.data.stripe_file import Stripes
from robolaser.errors import ImageError
from robolaser.model.sensors import sensor_class
from robolaser.vision.board_orientation import oriented
from robolaser.vision.board_placement import jumps
from robolaser.vision.extract import Extraction, Look, frame_of, look, on_board
from robolaser.vision.lens import find_lens, view_board
from robolaser.vision.stripe_trace import StripeSearch
from robolaser.vision.target_corners import Frame, corner_points, no_points, points_of_target

POINTS_PER_IMAGE = 170  # about, along a whole one: neighbouring lines share their scatter, so more add nothing


def points_from_images(
    recording: Dataset, *, progress: Progress | None = None, known: dict[object, Any] | None = None
) -> tuple[Extraction, Dataset]:
    """Detect board and stripe in every image.

    The recording has [board], [image] and a column `image` in poses.csv. A column `image_off` holds images with the
    laser off; `image_2`, `image_3` ... hold repeats. Detections are added to those known: no image is searched twice.

    Returns:
        The result for each image, and the data set with the points of two sensors, stripe and camera, and the scatter
        of the stripe's centre as its noise; frames without board or stripe have no points.

    Raises:
        DataError: poses.csv does not name the first image of a pose, or a path leaves the folder.
        ImageError: The recording has no board or images; an image is missing, broken or of another size; no image gave
            a point.
    """
    (shots, search), board = _images(recording), recording.board
    if board is None:
        raise no_points("dataset.toml has no [board] with columns, rows and square_m")
    known = {} if known is None else known
    seen: list[Look] = []
    for one in shots:
        key = one.files, search, board
        if key not in known:
            known[key] = look(one, search, board)
        seen.append(known[key])
        if progress is not None:
            progress("looking at images", len(seen) / len(shots))
    boards = {i: one.board.orientations for i, one in enumerate(seen) if one.board is not None}
    lens = find_lens([ways[0] for ways in boards.values()], board.square_m, *search.camera.size_px)
    turns = recording.flange()[[shots[i].row for i in boards], :3, :3]
    grids = dict(zip(boards, oriented(list(boards.values()), turns, lens)[0], strict=True))
    views = {i: view_board(grid, board.square_m, lens) for i, grid in grids.items()}
    apart = max(1, round(search.camera.size_px[1 if search.axis == "v" else 0] / POINTS_PER_IMAGE))
    found = [on_board(one.centres, views[i], lens, board, apart) if i in views else [] for i, one in enumerate(seen)]
    stripes = [one for ones in found for one in ones]
    frames = tuple(frame_of(shots[i].pose, one.centres, views.get(i), found[i]) for i, one in enumerate(seen))
    if not stripes:
        reasons = ", ".join(f"{frame.pose}: {frame.skipped}" for frame in frames[:3])
        raise ImageError(
            f"None of {len(frames)} images gave a point ({reasons}). Check [board] columns and rows (inner"
            " corners, not squares), stripe_axis, and that board and stripe are both in view."
        )
    noise_px = float(np.sqrt(np.mean(np.concatenate([jumps(one.off) for one in stripes]) ** 2)))
    points = Points(
        np.array([shots[i].row for i, ones in enumerate(found) for one in ones for _ in one.line], dtype=np.int64),
        tuple(f"{search.axis}{line:04d}" for one in stripes for line in one.line),
        repeat=np.array([one.repeat for one in stripes for _ in one.line]) if repeat_columns(recording.poses) else None,
        pixel=np.concatenate([one.pixel for one in stripes]),
        xyz=np.concatenate([one.place for one in stripes]),
    )
    corners = corner_points(board, [shots[i].row for i in grids], list(grids.values()))
    if len(recording.sensors) > 1:
        both = with_points_of(recording, [points, corners])
    else:
        both = scanner_with_corners(replace(recording, points=points), corners)
    return Extraction(points, frames, lens, noise_px, search.channel), _with_noise_stated(both, noise_px)


def points_of_images(
    recording: Dataset, *, progress: Progress | None = None, known: dict[object, Any] | None = None
) -> tuple[Extraction | Sequence[Frame], Dataset]:
    """The points in images of a stripe scanner or a camera: see `points_from_images` and `points_of_target`.

    Raises:
        ImageError: It has other sensors than one of them, or than a scanner and the camera that it shares.
    """
    has_stripe = sensor_class(recording.kind).has_laser_plane()
    first, *others = recording.sensors
    if others and not (has_stripe and [(one.data.kind, one.camera) for one in others] == [("camera", first.camera)]):
        raise no_points("of several sensors, only a stripe scanner and the camera that it shares have common images")
    look = points_from_images if has_stripe else points_of_target
    return look(recording, progress=progress, known=known)


def _with_noise_stated(dataset: Dataset, pixel_px: float) -> Dataset:
    """The data set with the scatter of the stripe's centre as its pixel noise, unless it states one."""
    if dataset.noise.pixel_px is not None or not pixel_px > 0:
        return dataset
    stated = replace(dataset.noise, pixel_px=pixel_px)
    members = [
        replace(one, data=replace(one.data, noise=stated)) if one.data.kind == dataset.kind else one
        for one in dataset.members
    ]
    return replace(dataset, noise=stated, members=tuple(members))


def stripes_from_images(recording: Dataset, *, progress: Progress | None = None) -> Iterator[Stripes]:
    """Trace the stripe in every image, on any surface, an image at a time.

    The recording has [image] and a column `image` in poses.csv, and others as for points.

    Yields:
        The centres of each image, with repeats, (n,) of STRIPE.

    Raises:
        DataError: poses.csv does not name the first image of a pose, or a path leaves the folder.
        ImageError: The recording has no images; an image is missing, broken or of another size; none shows a stripe.
    """
    shots, search = _images(recording)
    some = False
    for done, one in enumerate(shots, start=1):
        for stripes in search.traces(one):
            some = some or len(stripes) > 0
            yield stripes
        if progress is not None:
            progress("looking at images", done / len(shots))
    if not some:
        lines = "rows" if search.axis == "v" else "columns"
        raise ImageError(
            f"None of {len(shots)} images shows a stripe that crosses the {lines} of pixels. Check that the laser"
            f" is on, the exposure, and [sensor] stripe_axis, which is '{search.axis}'."
        )


def _images(recording: Dataset) -> tuple[list[PoseImages], StripeSearch]:
    """The images of each pose that has any, and the search for the stripe in them."""
    if not sensor_class(recording.kind).has_laser_plane() or recording.folder is None or recording.image_px is None:
        raise no_points("only stripe scanners take images")
    shots = images_of_poses(recording)
    if not shots:
        board = "" if recording.board is not None else ", and dataset.toml no [board]"
        raise no_points(f"poses.csv has no column 'image' with images{board}")
    return shots, StripeSearch.of(recording, shots)
