"""Where the stripes of a recording come from: stripes.npy, points.csv or the images themselves, piece by piece."""

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from functools import partial
from pathlib import Path
from typing import TYPE_CHECKING, final

import numpy as np

from robolaser.arrays import Ints
from robolaser.data.dataset import Dataset, Points
from robolaser.data.image_list import PoseImages, images_of_poses
from robolaser.data.stripe_file import FILE, STRIPE, Stripes, open_stripes
from robolaser.data.subsampling import evenly
from robolaser.errors import DataError, ScanError, unreadable

if TYPE_CHECKING:
    from robolaser.vision.stripe_trace import StripeSearch

AT_ONCE = 1 << 14  # line centres that a core takes at a time: they and their points stay in its cache
SAMPLES = 2000  # line centres for which the sizes of doubts are worked out


@final
@dataclass(frozen=True)
class Source:
    """The stripes of a recording."""

    what: str  # where they come from, for people
    pieces: Sequence[Callable[[], Stripes]]  # each gives some line centres when called, from any thread, (n,) of STRIPE
    points: Points | None = None  # the rows of points.csv, where these are the only piece; else None


def source_of(recording: Dataset, pixel_px: float) -> Source:
    """The best there is: stripes.npy, else points.csv, else images.

    Args:
        recording: On disk.
        pixel_px: Standard deviation of a line centre where its own is not known [px].

    Raises:
        ScanError: There is none of them, or stripes.npy is empty.
        DataError: stripes.npy is broken.
        DataError: poses.csv names images as it must not.
    """
    folder = recording.folder
    if folder is not None and (folder / FILE).exists():
        return _from_file(folder / FILE)
    rows = np.sort(np.concatenate([one.rows for one in recording.sensors if one.data.kind == recording.kind]))
    if len(rows):  # without a board's corners, which are on no stripe
        points = recording.points.take(rows)
        return Source("points.csv", [partial(_from_points, points, pixel_px)], points)
    shots = images_of_poses(recording)
    if not shots:
        raise ScanError(
            f"{folder} has neither stripes.npy nor points.csv nor images named in poses.csv: there is nothing to scan."
            " Record images, or run `robolaser extract` on them."
        )
    from robolaser.vision.stripe_trace import StripeSearch  # noqa: PLC0415 - OpenCV is slow to load

    search = StripeSearch.of(recording, shots)
    return Source("images", [partial(_found, search, one) for one in shots])


def sample_points(source: Source, recording: Dataset) -> Points:
    """Some line centres, evenly taken from the whole recording; of images, which are not read yet, pixels all over."""
    if source.what == "images":
        return points_in_images(recording, np.array([shots.row for shots in images_of_poses(recording)]))
    if source.points is not None:
        return source.points.take(evenly(len(source.points), SAMPLES))
    assert recording.folder is not None  # stripes.npy lies in it
    stripes = open_stripes(recording.folder / FILE)
    some = stripes[evenly(len(stripes), SAMPLES)]
    check_poses(some, recording)
    return as_points(some)


def points_in_images(recording: Dataset, rows: Ints) -> Points:
    """Pixels all over the image in some of the poses with these numbers, (n,)."""
    assert recording.image_px is not None  # a stripe's data set has a size
    grid = np.linspace(0.2, 0.8, 3)
    places = np.stack(np.meshgrid(*(side * grid for side in recording.image_px)), axis=-1).reshape(-1, 2)
    some = rows[evenly(len(rows), SAMPLES // len(places))]
    return Points(some.repeat(len(places)), (), pixel=np.tile(places, (len(some), 1)))


def as_points(stripes: Stripes) -> Points:
    """Line centres as points of a data set; they have no names."""
    pixel = np.empty((len(stripes), 2))
    pixel[:, 0], pixel[:, 1] = stripes["u"], stripes["v"]
    return Points(stripes["pose"].astype(np.int64), (), pixel=pixel)


def check_poses(stripes: Stripes, recording: Dataset) -> None:
    """Check that all line centres are of poses that exist.

    Raises:
        DataError: They are not.
    """
    last = int(stripes["pose"].max(initial=0))
    if len(stripes) and last >= len(recording.poses):
        raise DataError(
            f"{FILE} of {recording.folder} has line centres of row {last} of poses.csv, whose rows are 0 to"
            f" {len(recording.poses) - 1}. They do not belong to one recording: run `robolaser extract --force` again.",
            file=FILE,
        )


def no_line_centres(source: str) -> ScanError:
    """No stripe was found."""
    return ScanError(
        f"No image shows a stripe: there is no line centre in {source}. Check that the laser was on, the exposure, and"
        " [sensor] stripe_axis; then record again, or run `robolaser extract --force`."
    )


def _from_file(path: Path) -> Source:
    """Pieces of a file, each read when it is its turn: mapped memory would seem to grow with the scan."""
    stripes = open_stripes(path)
    if not isinstance(stripes, np.memmap):
        raise no_line_centres(str(path))
    start, count = stripes.offset, len(stripes)
    return Source(FILE, [partial(_read, path, start, first, count) for first in range(0, count, AT_ONCE)])


def _read(path: Path, start: int, first: int, count: int) -> Stripes:
    most = min(AT_ONCE, count - first)
    try:
        piece = np.fromfile(path, STRIPE, most, offset=start + first * STRIPE.itemsize)
    except OSError as error:
        raise unreadable(path, error.strerror or str(error)) from None
    if len(piece) < most:
        raise unreadable(path, "it became shorter while it was read")
    return piece


def _found(search: "StripeSearch", one: PoseImages) -> Stripes:
    return np.asarray(np.concatenate(list(search.traces(one))))


def _from_points(points: Points, pixel_px: float) -> Stripes:
    stripes = np.empty(len(points), STRIPE)
    stripes["pose"], stripes["std"], stripes["intensity"] = points.pose, pixel_px, np.nan
    stripes["u"], stripes["v"] = points["pixel"].T
    return stripes
