"""A laser stripe in an image: where its centre lies, in every line of pixels that crosses it."""

import cv2
import numpy as np

from robolaser.vision.board import Image
from robolaser.vision.candidates import Axis, LineCentres
from robolaser.vision.line_centres import DEFAULT, PEAK_DETECTORS
from robolaser.vision.profiles import measure
from robolaser.vision.runs import find_runs


def find_line_centres(image: Image, axis: Axis, detector: str = DEFAULT) -> LineCentres:
    """Find every bright run that may be the stripe and the middle of each, to a fraction of a pixel.

    Runs cut by the image's border have no centre and are left out.

    Args:
        image: Grey image, (height, width).
        axis: Image axis that the stripe runs along: one centre per row for "v", per column for "u".
        detector: Name of the way to the centre, one of PEAK_DETECTORS.

    Returns:
        The candidates, by line and then by place in the line.
    """
    across = image if axis == "v" else np.asarray(cv2.transpose(image), dtype=image.dtype)
    runs = find_runs(across)
    profiles = measure(runs)
    centre, std = PEAK_DETECTORS[detector](runs, profiles)
    found = LineCentres(
        line=runs.line,
        pixel=np.stack([centre, runs.line] if axis == "v" else [runs.line, centre], axis=-1),
        std=std,
        width=profiles.width,
        light=profiles.light,
        peak=profiles.peak,
        ground=profiles.ground,
        asymmetry=profiles.asymmetry,
    )
    return found.at(np.isfinite(centre) & np.isfinite(profiles.centre) & np.isfinite(std))
