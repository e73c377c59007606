"""A recording is a data set whose points are still in its images."""

from collections.abc import Iterator
from dataclasses import replace

import numpy as np

from robolaser.calibration.pymoo_search import Progress
from robolaser.data.dataset import Dataset, Points
from robolaser.data.image_list import Shots, repeats_of, shots_of
from robolaser.data.stripe_file import Stripes
from robolaser.errors import NoStripes, NotARecording, NothingExtracted
from robolaser.vision.centres import Axis, every
from robolaser.vision.extract import Extraction, extract_points
from robolaser.vision.line_centers import DEFAULT
from robolaser.vision.traced import traces


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
        ImageUnnamed, DataError: poses.csv names images as it must not.
        ImageUnreadable, ImageSize: An image is missing, broken or of another size.
        NothingExtracted: No image gave a point.
    """
    shots, axis, size = _images(recording)
    board = recording.board
    if board is None:
        raise NotARecording("dataset.toml has no [board] with columns, rows and square_m")
    found = extract_points(
        shots,
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
    points = Points(
        pose=np.array([number[pose] for pose in found.pose], dtype=np.int64),
        names=found.point,
        repeat=found.repeat if repeats_of(recording.poses) else None,
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
        ImageUnnamed, DataError: poses.csv names images as it must not.
        ImageUnreadable, ImageSize: An image is missing, broken or of another size.
        NoStripes: No image shows a stripe.
    """
    shots, axis, size = _images(recording)
    some = False
    for done, one in enumerate(shots, start=1):
        for found in traces(one, size, axis, centring):
            stripes = found if step is None else found[every(np.rint(found[axis]).astype(np.int64), step)]
            some = some or len(stripes) > 0
            yield stripes
        if progress is not None:
            progress("looking at images", done / len(shots))
    if not some:
        raise NoStripes(len(shots), axis)


def _images(recording: Dataset) -> tuple[list[Shots], Axis, tuple[int, int]]:
    """The images of each pose that has any, the stripe's axis, and the images' size."""
    size = recording.image_px
    if recording.kind != "stripe" or recording.folder is None or size is None:
        raise NotARecording("only stripe scanners take images")
    shots = shots_of(recording)
    if not shots:
        board = "" if recording.board is not None else ", and dataset.toml no [board]"
        raise NotARecording(f"poses.csv has no column 'image' with images{board}")
    return shots, "u" if recording.stripe_axis == "u" else "v", size
