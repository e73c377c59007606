"""One stripe traced through one image of anything, as a scan keeps it."""

from collections.abc import Iterator

import numpy as np

from robolaser.data.image_list import PoseImages
from robolaser.data.stripe_file import STRIPE, Stripes
from robolaser.vision.board import Image
from robolaser.vision.candidates import Axis
from robolaser.vision.images import laser_alone, lights
from robolaser.vision.light_channel import CHANNELS
from robolaser.vision.line_centres import DEFAULT
from robolaser.vision.line_tracking import track_stripe
from robolaser.vision.stripe_detection import find_line_centres


def trace(image: Image, axis: Axis, off: Image | None = None, detector: str = DEFAULT) -> Stripes:
    """Find the stripe in an image, one centre at most in each line of pixels.

    A centre's standard deviation is what the image's noise makes of it, or what the scatter along the stripe shows
    where that is more (speckle, rough surfaces).

    Args:
        image: Grey image with the laser on, (height, width).
        axis: Image axis that the stripe runs along.
        off: The same view with the laser off; what both show is no stripe.
        detector: Name of the way to the centre, one of PEAK_DETECTORS.

    Returns:
        The centres, (n,) of STRIPE, along the stripe; their pose is 0.
    """
    centres = find_line_centres(image if off is None else laser_alone(image, off), axis, detector)
    chosen, excess = track_stripe(centres, centres.pixel[:, 0 if axis == "v" else 1])
    found = centres.at(chosen)
    stripes = np.zeros(len(found), STRIPE)
    stripes["u"], stripes["v"] = found.pixel.T
    stripes["std"] = excess * found.std
    stripes["intensity"] = found.peak - found.ground
    return stripes


def traces(
    shots: PoseImages,
    size_px: tuple[int, int],
    axis: Axis,
    detector: str = DEFAULT,
    *,
    channel: str = "grey",
    exposures: bool = False,
) -> Iterator[Stripes]:
    """Trace the stripe in each image of a pose that was taken with the laser on.

    Args:
        shots: The images.
        size_px: Width and height that each must have.
        axis: Image axis that the stripe runs along.
        detector: Name of the way to the stripe's centre.
        channel: Name of the channel in which the light stands out, one of CHANNELS.
        exposures: Whether the images of the pose are an exposure series: they are one stripe.

    Yields:
        The centres of each, repeats among them, (n,) of STRIPE.

    Raises:
        ImageError: An image is missing, broken or of another size.
    """
    for _, light in lights(shots, size_px, CHANNELS[channel], axis if exposures else None):
        stripes = trace(light, axis, detector=detector)
        stripes["pose"] = shots.row
        yield stripes
