"""The camera's images of the poses that err most, small enough for a page: points extracted and points predicted."""

import base64
import io
import warnings
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Final

import numpy as np

from robolaser.arrays import Array
from robolaser.bounded_reading import IMAGE_BYTES, pixels_of, read_bytes
from robolaser.calibration.result import rms
from robolaser.data.dataset import Dataset
from robolaser.data.subsampling import evenly
from robolaser.errors import DataError
from robolaser.report.digits import millimetres
from robolaser.report.error_analysis import lengths_mm
from robolaser.report.scene import Photo

MOST: Final = 10
MOST_POINTS: Final = 80
"""Of an image."""
WIDTH_PX: Final = 560
QUALITY: Final = 55
"""Of JPEG: an image takes 10 to 40 kB."""


def photos(dataset: Dataset, frames: Sequence[int], errors_m: Array, misses: Array | None) -> Mapping[str, Photo]:
    """Images of some of these poses by their names, the worst first; none where there are none to be read.

    Args:
        dataset: What was measured.
        frames: Numbers of the poses.
        errors_m: Errors of all rows [m].
        misses: From each row's pixel to where the model predicts it, (m, 2) [px]; None where it does not.
    """
    images, pixel, of_pose = dataset.poses.image, dataset.points.pixel, dataset.points.pose
    if images is None or dataset.folder is None or pixel is None or dataset.image_px is None:
        return {}
    made: dict[str, Photo] = {}
    for pose in sorted(frames, key=lambda pose: -rms(errors_m[of_pose == pose])):
        source = _small(dataset.folder / images[pose], dataset.image_px) if images[pose] and len(made) < MOST else ""
        if source:
            rows = np.flatnonzero(of_pose == pose)
            rows = rows[evenly(len(rows), MOST_POINTS)]
            lengths = lengths_mm(errors_m[rows])
            off = np.full((len(rows), 2), np.nan) if misses is None else misses[rows]
            names = [
                f"point {dataset.points.names[row]}\nerror {millimetres(length / 1e3)}"
                + (f"\n{px:.2g} px from where the model predicts it" if np.isfinite(px) else "")
                for row, length, px in zip(rows, lengths, np.linalg.norm(off, axis=1), strict=True)
            ]
            made[dataset.poses.names[pose]] = Photo(source, dataset.image_px, pixel[rows], off, names)
    return made


def _small(path: Path, size_px: tuple[int, int]) -> str:
    """An image as a data URI; empty where it cannot be read, or has another size than was stated."""
    from PIL import Image  # noqa: PLC0415 - slow to import

    try:
        coded = read_bytes(path, IMAGE_BYTES)
        if pixels_of(coded) != size_px:
            return ""
        with warnings.catch_warnings(action="ignore"), Image.open(io.BytesIO(coded)) as opened:
            opened.draft("L", (WIDTH_PX, WIDTH_PX))
            small = opened.convert("L")
        small.thumbnail((WIDTH_PX, WIDTH_PX), Image.Resampling.BILINEAR, reducing_gap=2.0)
        out = io.BytesIO()
        small.save(out, "JPEG", quality=QUALITY)
    except (DataError, OSError, ValueError, SyntaxError, Image.DecompressionBombError):
        return ""
    return f"data:image/jpeg;base64,{base64.b64encode(out.getvalue()).decode()}"
