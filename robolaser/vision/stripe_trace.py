"""One stripe traced through one image of anything, as a scan keeps it."""

from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from typing import final

import numpy as np

from robolaser.data.dataset import Dataset
from robolaser.data.image_list import PoseImages
from robolaser.data.stripe_file import STRIPE, Stripes
from robolaser.vision.board import Image
from robolaser.vision.images import CameraImages, lights
from robolaser.vision.light_channel import AUTO, CHANNELS, find_channel
from robolaser.vision.line_tracking import track_stripe
from robolaser.vision.runs import Axis
from robolaser.vision.stripe_detection import find_line_centres


def trace(image: Image, axis: Axis) -> Stripes:
    """Find the stripe in an image, one centre at most in each line of pixels.

    A centre's standard deviation is what the image's noise makes of it, or what the scatter along the stripe shows
    where that is more (speckle, rough surfaces).

    Args:
        image: Grey image of the laser's light, (height, width).
        axis: Image axis that the stripe runs along.

    Returns:
        The centres, (n,) of STRIPE, along the stripe; their pose is 0.
    """
    centres = find_line_centres(image, axis)
    chosen, excess = track_stripe(centres)
    found = centres.at(chosen)
    stripes = np.zeros(len(found), STRIPE)
    stripes["u"], stripes["v"] = found.pixel.T
    stripes["std"] = excess * found.std
    stripes["intensity"] = found.peak - found.ground
    return stripes


@final
@dataclass(frozen=True)
class StripeSearch:
    """How the stripe is looked for in the images of a recording."""

    camera: CameraImages
    axis: Axis  # image axis that the stripe runs along
    channel: str = "grey"  # name of the channel in which the light stands out, one of CHANNELS
    exposures: bool = False  # whether the images of a pose are an exposure series, and no repeats

    @classmethod
    def of(
        cls, recording: Dataset, shots: Sequence[PoseImages], *, channel: str = AUTO, exposures: bool = False
    ) -> "StripeSearch":
        """How to look in the images of a stripe scanner's recording; AUTO is the channel in which the light stands out.

        Raises:
            ImageError: An image is missing, broken or of another size.
        """
        assert recording.image_px is not None  # a stripe's data set has a size
        camera = CameraImages.of((file for one in shots for file in one.files), recording.image_px)
        axis: Axis = "u" if recording.stripe_axis == "u" else "v"
        channel = find_channel(shots, camera, axis) if channel == AUTO else channel
        return cls(camera, axis, channel, exposures)

    def lights(self, shots: PoseImages) -> Iterator[tuple[Image, Image]]:
        """Give each image of a pose with the laser on, and in it the laser's light.

        Raises:
            ImageError: An image is missing, broken or of another size.
        """
        return lights(shots, self.camera, CHANNELS[self.channel], self.axis if self.exposures else None)

    def traces(self, shots: PoseImages) -> Iterator[Stripes]:
        """Trace the stripe in each image of a pose with the laser on, repeats among them, (n,) of STRIPE.

        Raises:
            ImageError: An image is missing, broken or of another size.
        """
        for _, light in self.lights(shots):
            stripes = trace(light, self.axis)
            stripes["pose"] = shots.row
            yield stripes
