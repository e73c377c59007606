"""One stripe traced through any image, in the channel in which the laser is the most visible."""

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from typing import final

import cv2
import numpy as np

from robolaser.arrays import Image
from robolaser.data.dataset import Dataset
from robolaser.data.image_list import PoseImages
from robolaser.data.stripe_file import STRIPE, Stripes
from robolaser.vision.images import CameraImages, Weights, eight_bits, laser_alone, light_in, read_image
from robolaser.vision.line_tracking import track_stripe
from robolaser.vision.runs import ImageAxis
from robolaser.vision.stripe_detection import find_line_centres

CHANNELS: Mapping[str, Weights | None] = {
    "grey": None,
    "red": (0.0, 0.0, 1.0),
    "green": (0.0, 1.0, 0.0),
    "blue": (1.0, 0.0, 0.0),
    "red-excess": (-0.5, -0.5, 1.0),
    "green-excess": (-0.5, 1.0, -0.5),
    "blue-excess": (1.0, -0.5, -0.5),
}
"""Weights of blue, green and red by name; an excess is half of 2R - G - B, 2G - R - B or 2B - R - G. None: grey."""
LOOKED_AT = 3  # poses, evenly taken, for the choice of a channel
COLOURFUL = 12  # least difference of two channels [grey of 255] in a coloured pixel
BETTER = 1.1  # least length of a stripe in another channel over that in grey, which has the least noise


def trace(image: Image, axis: ImageAxis) -> Stripes:
    """Find the stripe in a grey image of the laser's light, one centre at most in each line of pixels.

    A centre's standard deviation is that by the image's noise, or by the scatter along the stripe where that is larger
    (speckle, rough surfaces).

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
    """The search for the stripe in the images of a recording."""

    camera: CameraImages
    axis: ImageAxis  # image axis that the stripe runs along
    channel: str = "grey"  # name of the channel with the most visible light, one of CHANNELS

    @classmethod
    def of(cls, recording: Dataset, shots: Sequence[PoseImages]) -> "StripeSearch":
        """The search in a stripe scanner's recording, in the channel with the most visible light."""
        assert recording.image_px is not None  # data sets of stripes have an image size
        camera = CameraImages.of((file for one in shots for file in one.files), recording.image_px)
        axis: ImageAxis = "u" if recording.stripe_axis == "u" else "v"
        return cls(camera, axis, find_channel(shots, camera, axis))

    def lights(self, shots: PoseImages) -> Iterator[tuple[Image, Image]]:
        """Yield each image of a pose with the laser on as eight bits of grey, and the laser's light in it, if known.

        Both are (height, width). The light of deeper images has fractions of an eight-bit grey.
        """
        weights, depth = CHANNELS[self.channel], self.camera.depth
        colours = cv2.IMREAD_GRAYSCALE if weights is None else cv2.IMREAD_COLOR
        raw = [read_image(path, self.camera.size_px, colours) for path in shots.files]
        grey = [eight_bits(one if weights is None else cv2.cvtColor(one, cv2.COLOR_BGR2GRAY), depth) for one in raw]
        light = [light_in(one, depth, weights) for one in raw]
        lit = len(shots.lit)
        for image, one in zip(grey[:lit], light[:lit], strict=True):
            yield image, one if shots.unlit is None else laser_alone(one, light[lit])

    def traces(self, shots: PoseImages) -> Iterator[Stripes]:
        """Trace the stripe in each image of a pose with the laser on, with repeats, (n,) of STRIPE."""
        for _, light in self.lights(shots):
            stripes = trace(light, self.axis)
            stripes["pose"] = shots.row
            yield stripes


def find_channel(shots: Sequence[PoseImages], camera: CameraImages, axis: ImageAxis) -> str:
    """Name of the channel in which the stripe is the longest in some of the images; "grey" of grey images.

    An image with the laser off is subtracted in each channel first.
    """
    some = [shots[i] for i in np.unique(np.linspace(0, len(shots) - 1, LOOKED_AT).astype(np.int64))] if shots else []
    seen = (eight_bits(read_image(one.lit[0], camera.size_px, cv2.IMREAD_COLOR), camera.depth) for one in some)
    if not any(map(_is_colourful, seen)):
        return "grey"
    found = {name: sum(_length(one, StripeSearch(camera, axis, name)) for one in some) for name in CHANNELS}
    best = max(found, key=lambda name: found[name])
    return best if found[best] > BETTER * found["grey"] else "grey"


def _is_colourful(image: Image) -> bool:
    blue, green, red = cv2.split(image)
    return bool((cv2.absdiff(red, green) > COLOURFUL).any() or (cv2.absdiff(blue, green) > COLOURFUL).any())


def _length(shots: PoseImages, search: StripeSearch) -> float:
    """Number of lines of pixels with the stripe, each weighted by its certainty relative to about 0.1 pixel."""
    _, light = next(search.lights(shots))
    return float((1.0 / (1.0 + (trace(light, search.axis)["std"] / 0.1) ** 2)).sum())
