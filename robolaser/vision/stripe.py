"""A laser stripe in an image: where its middle lies, in every line of pixels that crosses it."""

import cv2
import numpy as np

from robolaser.vision.board import Image
from robolaser.vision.centres import Axis, Centres
from robolaser.vision.line_centers import CENTRINGS, DEFAULT
from robolaser.vision.line_centers.center_of_gravity import measure
from robolaser.vision.runs import find_runs


def stripe_centres(image: Image, axis: Axis, centring: str = DEFAULT) -> Centres:
    """Find every bright run that may be the stripe and the middle of each, to a fraction of a pixel.

    Runs cut by the image's border have no middle and are left out.

    Args:
        image: Grey image, (height, width).
        axis: Image axis that the stripe runs along: one middle per row for "v", per column for "u".
        centring: Name of the way to the middle, one of CENTRINGS.

    Returns:
        The candidates, by line and then by place in the line.
    """
    across = image if axis == "v" else np.asarray(cv2.transpose(image), dtype=np.uint8)
    runs = find_runs(across)
    profiles = measure(runs)
    middle, std = CENTRINGS[centring](runs, profiles)
    found = Centres(
        line=runs.line,
        pixel=np.stack([middle, runs.line] if axis == "v" else [runs.line, middle], axis=-1),
        std=std,
        width=profiles.width,
        light=profiles.light,
        peak=profiles.peak,
        ground=profiles.ground,
        lopsided=profiles.lopsided,
    )
    return found.at(np.isfinite(middle) & np.isfinite(profiles.middle) & np.isfinite(std))
