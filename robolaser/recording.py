"""A recording is a data set whose points are still in its images."""

from dataclasses import replace

import numpy as np

from robolaser.dataset import Dataset, Points
from robolaser.errors import NotARecording, NothingExtracted
from robolaser.folder import inside
from robolaser.search import Progress
from robolaser.vision.extract import Extraction, extract_points


def points_from_images(
    recording: Dataset, *, step: int | None = None, progress: Progress | None = None
) -> tuple[Extraction, Dataset]:
    """Find board and stripe in every image.

    Args:
        recording: A data set on disk with [board], [image] and a column `image` in poses.csv.
        step: Lines of pixels from one point to the next.
        progress: Is told how far it is.

    Returns:
        What was found in each image, and the data set with the points; frames without board or stripe have none.

    Raises:
        NotARecording: It says nothing of board or images.
        ImageUnreadable, ImageSize: An image is missing, broken or of another size.
        NothingExtracted: No image gave a point.
    """
    folder, images, board, size = recording.folder, recording.poses.image, recording.board, recording.image_px
    if recording.kind != "stripe" or folder is None or size is None:
        raise NotARecording("only stripe scanners take images")
    if board is None:
        raise NotARecording("dataset.toml has no [board] with columns, rows and square_m")
    if images is None or not any(images):
        raise NotARecording("poses.csv has no column 'image'")
    found = extract_points(
        [
            (pose, inside(folder, image, "poses.csv, column image"))
            for pose, image in zip(recording.poses.names, images, strict=True)
            if image
        ],
        columns=board.columns,
        rows=board.rows,
        square_m=board.square_m,
        stripe_axis="u" if recording.stripe_axis == "u" else "v",
        width_px=size[0],
        height_px=size[1],
        step=step,
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
        pixel=found.pixel,
        xyz=found.place,
    )
    return found, replace(recording, points=points)
