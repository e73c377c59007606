"""One stripe traced through one image of anything, as a scan keeps it."""

from collections.abc import Iterator

import numpy as np

from robolaser.data.image_list import Shots
from robolaser.data.stripe_file import STRIPE, Stripes
from robolaser.vision.board import Image
from robolaser.vision.centres import Axis
from robolaser.vision.images import ambient, laser_alone, lights
from robolaser.vision.line_centers import DEFAULT
from robolaser.vision.line_tracking import one_stripe
from robolaser.vision.stripe import stripe_centres


def trace(image: Image, axis: Axis, off: Image | None = None, centring: str = DEFAULT) -> Stripes:
    """Find the stripe in an image, one middle at most in each line of pixels.

    A middle's standard deviation is what the image's noise makes of it, or what the scatter along the stripe shows
    where that is more (speckle, rough surfaces).

    Args:
        image: Grey image with the laser on, (height, width).
        axis: Image axis that the stripe runs along.
        off: The same view with the laser off; what both show is no stripe.
        centring: Name of the way to the middle, one of CENTRINGS.

    Returns:
        The middles, (n,) of STRIPE, along the stripe; their pose is 0.
    """
    centres = stripe_centres(image if off is None else laser_alone(image, off), axis, centring)
    chosen, excess = one_stripe(centres, centres.pixel[:, 0 if axis == "v" else 1])
    found = centres.at(chosen)
    stripes = np.zeros(len(found), STRIPE)
    stripes["u"], stripes["v"] = found.pixel.T
    stripes["std"] = excess * found.std
    stripes["intensity"] = found.peak - found.ground
    return stripes


def traces(shots: Shots, size_px: tuple[int, int], axis: Axis, centring: str = DEFAULT) -> Iterator[Stripes]:
    """Trace the stripe in each image of a pose that was taken with the laser on.

    Args:
        shots: The images.
        size_px: Width and height that each must have.
        axis: Image axis that the stripe runs along.
        centring: Name of the way to the stripe's middle.

    Yields:
        The middles of each, repeats among them, (n,) of STRIPE.

    Raises:
        ImageUnreadable, ImageSize: An image is missing, broken or of another size.
    """
    for _, light in lights(shots, size_px, ambient(shots, size_px)):
        stripes = trace(light, axis, centring=centring)
        stripes["pose"] = shots.row
        yield stripes
