"""A recording is a data set whose points are still in its images."""

from collections.abc import Iterator, Sequence
from dataclasses import replace
from typing import Any

from robolaser.arrays import Progress
from robolaser.data.dataset import Dataset
from robolaser.data.image_list import PoseImages, images_of_poses, repeat_columns
from robolaser.data.several_sensors import scanner_with_corners, with_points_of
from robolaser.data.stripe_file import Stripes
from robolaser.errors import ImageError
from robolaser.model.sensors import sensor_class
from robolaser.vision.extract import Extraction, extract_points
from robolaser.vision.stripe_trace import StripeSearch
from robolaser.vision.target_corners import Frame, corner_points, points_of_target


def points_from_images(
    recording: Dataset, *, progress: Progress | None = None, known: dict[object, Any] | None = None
) -> tuple[Extraction, Dataset]:
    """Find board and stripe in every image.

    Args:
        recording: A data set on disk with [board], [image] and a column `image` in poses.csv. A column `image_off`
            holds images with the laser off; `image_2`, `image_3` ... hold repeats.
        progress: Called with what is being done and the share that is done.
        known: What images showed earlier; what these show is added, and nothing is looked for twice.

    Returns:
        What was found in each image, and the data set with the points of two sensors, stripe and camera, and the
        scatter of the stripe's centre as its noise; frames without board or stripe have none.

    Raises:
        DataError: poses.csv does not name the first image of a pose, or a path leaves the folder.
        ImageError: The recording has no board or images; an image is missing, broken or of another size; no image gave
            a point.
    """
    shots, search = _images(recording)
    if recording.board is None:
        raise _no_points("dataset.toml has no [board] with columns, rows and square_m")
    found = extract_points(
        shots,
        search,
        recording.board,
        R_base_flange=recording.flange()[[one.row for one in shots], :3, :3],
        known=known,
        progress=None if progress is None else lambda done, of: progress("looking at images", done / of),
    )
    if not len(found):
        reasons = ", ".join(f"{frame.pose}: {frame.skipped}" for frame in found.frames[:3])
        raise ImageError(
            f"None of {len(found.frames)} images gave a point ({reasons}). Check [board] columns and rows (inner"
            " corners, not squares), stripe_axis, and that board and stripe are both in view."
        )
    points = found.points if repeat_columns(recording.poses) else replace(found.points, repeat=None)
    corners = corner_points(recording.board, list(found.corners), list(found.corners.values()))
    if len(recording.sensors) > 1:
        kinds = [sensor.data.kind for sensor in recording.sensors]
        both = with_points_of(recording, [points if kind == recording.kind else corners for kind in kinds])
    else:
        both = scanner_with_corners(replace(recording, points=points), corners)
    return found, _with_noise_stated(both, found.pixel_noise_px)


def points_of_images(
    recording: Dataset, *, progress: Progress | None = None, known: dict[object, Any] | None = None
) -> tuple[Extraction | Sequence[Frame], Dataset]:
    """What the images of a stripe scanner or a camera show: see `points_from_images` and `points_of_target`."""
    look = points_from_images if sensor_class(recording.kind).has_laser_plane() else points_of_target
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
    """Trace the stripe in every image, whatever it lies on, an image at a time.

    Args:
        recording: A data set on disk with [image] and a column `image` in poses.csv, and others as for points.
        progress: Called with what is being done and the share that is done.

    Yields:
        The centres of each image, repeats among them, (n,) of STRIPE.

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


def _no_points(reason: str) -> ImageError:
    return ImageError(f"There are no points to extract: {reason}.")


def _images(recording: Dataset) -> tuple[list[PoseImages], StripeSearch]:
    """The images of each pose that has any, and how the stripe is looked for in them."""
    if not sensor_class(recording.kind).has_laser_plane() or recording.folder is None or recording.image_px is None:
        raise _no_points("only stripe scanners take images")
    shots = images_of_poses(recording)
    if not shots:
        board = "" if recording.board is not None else ", and dataset.toml no [board]"
        raise _no_points(f"poses.csv has no column 'image' with images{board}")
    return shots, StripeSearch.of(recording, shots)
