"""A recording is a data set whose points are still in its images."""

import re
from collections.abc import Iterator
from dataclasses import replace
from pathlib import Path

import numpy as np

from robolaser.dataset import Dataset, Points, Poses
from robolaser.errors import NoStripes, NotARecording, NothingExtracted
from robolaser.folder import inside
from robolaser.search import Progress
from robolaser.stripes import Stripes
from robolaser.vision.centres import Axis
from robolaser.vision.centring import DEFAULT
from robolaser.vision.extract import Extraction, extract_points
from robolaser.vision.shots import Shots
from robolaser.vision.traced import trace

UNLIT = "image_off"
"""Column of poses.csv with the image taken with the laser off."""
REPEAT = re.compile(r"image_([2-9]|[1-9]\d+)")
"""Columns with further images of the unmoved arm, laser on."""


def image_columns(poses: Poses) -> list[str]:
    """Columns of poses.csv that name images: with the laser on, in order, then without."""
    repeats = sorted((column for column in poses.extra if REPEAT.fullmatch(column)), key=lambda name: int(name[6:]))
    return ["image", *repeats, *([UNLIT] if UNLIT in poses.extra else [])]


def points_from_images(
    recording: Dataset, *, step: int | None = None, centring: str = DEFAULT, progress: Progress | None = None
) -> tuple[Extraction, Dataset]:
    """Find board and stripe in every image.

    Args:
        recording: A data set on disk with [board], [image] and a column `image` in poses.csv. A column `image_off`
            holds images with the laser off; `image_2`, `image_3` ... hold repeats.
        step: Lines of pixels from one point to the next.
        centring: Name of the way to the stripe's middle.
        progress: Is told how far it is.

    Returns:
        What was found in each image, and the data set with the points; frames without board or stripe have none.

    Raises:
        NotARecording: It says nothing of board or images.
        ImageUnreadable, ImageSize: An image is missing, broken or of another size.
        NothingExtracted: No image gave a point.
    """
    shots, axis, size, columns = _images(recording)
    board = recording.board
    if board is None:
        raise NotARecording("dataset.toml has no [board] with columns, rows and square_m")
    found = extract_points(
        [one for _, one in shots],
        columns=board.columns,
        rows=board.rows,
        square_m=board.square_m,
        stripe_axis=axis,
        width_px=size[0],
        height_px=size[1],
        step=step,
        centring=centring,
        R_base_flange=dict(zip(recording.poses.names, recording.flange()[:, :3, :3], strict=True)),
        progress=None if progress is None else lambda done, of: progress("looking at images", done / of),
    )
    if not len(found):
        reasons = ", ".join(f"{frame.pose}: {frame.skipped}" for frame in found.frames[:3])
        raise NothingExtracted(len(found.frames), reasons)
    number = {name: i for i, name in enumerate(recording.poses.names)}
    repeated = any(REPEAT.fullmatch(column) for column in columns)
    points = Points(
        pose=np.array([number[pose] for pose in found.pose], dtype=np.int64),
        names=found.point,
        repeat=found.repeat if repeated else None,
        pixel=found.pixel,
        xyz=found.place,
    )
    return found, replace(recording, points=points)


def stripes_from_images(
    recording: Dataset, *, step: int | None = None, centring: str = DEFAULT, progress: Progress | None = None
) -> Iterator[Stripes]:
    """Trace the stripe in every image, whatever it lies on, an image at a time.

    Args:
        recording: A data set on disk with [image] and a column `image` in poses.csv, and others as for points.
        step: Lines of pixels from one middle to the next; every line by default.
        centring: Name of the way to the stripe's middle.
        progress: Is told how far it is.

    Yields:
        The middles of each image, repeats among them, (n,) of STRIPE.

    Raises:
        NotARecording: It says nothing of images.
        ImageUnreadable, ImageSize: An image is missing, broken or of another size.
        NoStripes: No image shows a stripe.
    """
    shots, axis, size, _ = _images(recording)
    every = 1 if step is None else step
    some = False
    for done, (row, one) in enumerate(shots, start=1):
        ambient = one.ambient(*size)
        for image, _ in one.lights(*size, None):
            stripes = trace(image, axis, ambient, centring)
            line = np.rint(stripes["v" if axis == "v" else "u"]).astype(np.int64)
            stripes = stripes[line % every == every // 2]
            stripes["pose"] = row
            some = some or len(stripes) > 0
            yield stripes
        if progress is not None:
            progress("looking at images", done / len(shots))
    if not some:
        raise NoStripes(len(shots), axis)


def _images(recording: Dataset) -> tuple[list[tuple[int, Shots]], Axis, tuple[int, int], list[str]]:
    """Row and files of each pose that has an image, the stripe's axis, the images' size, and their columns."""
    folder, poses, size = recording.folder, recording.poses, recording.image_px
    if recording.kind != "stripe" or folder is None or size is None:
        raise NotARecording("only stripe scanners take images")
    if poses.image is None or not any(poses.image):
        board = "" if recording.board is not None else ", and dataset.toml no [board]"
        raise NotARecording(f"poses.csv has no column 'image' with images{board}")
    columns = image_columns(poses)
    lit = [column for column in columns if column != UNLIT]

    def file(column: str, row: int) -> Path | None:
        assert poses.image is not None
        name = poses.image[row] if column == "image" else poses.extra[column][row]
        return inside(folder, name, f"poses.csv, column {column}") if name else None

    shots = []
    for row, pose in enumerate(poses.names):
        if poses.image[row]:
            files = (file(column, row) for column in lit)
            unlit = file(UNLIT, row) if UNLIT in columns else None
            shots.append((row, Shots(pose, tuple(path for path in files if path is not None), unlit)))
    return shots, "u" if recording.stripe_axis == "u" else "v", size, columns
