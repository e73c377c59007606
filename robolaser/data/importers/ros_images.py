"""Images of a ROS bag as files."""

from typing import Any

import numpy as np

from robolaser.bounded_reading import decoded
from robolaser.errors import DataError

GREY, COLOUR = ("mono8", "8UC1", "mono16", "16UC1"), ("bgr8", "rgb8", "8UC3")
CHANNEL_COUNTS = {**dict.fromkeys(GREY, 1), **dict.fromkeys(COLOUR, 3), "bgra8": 4, "rgba8": 4}
BAYER = {"bayer_rggb8": "BayerBG", "bayer_bggr8": "BayerRG", "bayer_gbrg8": "BayerGR", "bayer_grbg8": "BayerGB"}
"""ROS names a pattern by its first row, OpenCV by its second row's second and third pixels."""


def image_file(message: Any, file: str, topic: str) -> tuple[str, bytes, tuple[int, int]]:
    """Suffix, contents and size [px] of the file of a message.

    Raises:
        DataError: It is of an encoding that is not known, or damaged.
    """
    import cv2  # noqa: PLC0415 - slow to import

    if not hasattr(message, "encoding"):
        data = np.asarray(message.data, dtype=np.uint8)
        image = decoded(data.tobytes(), cv2.IMREAD_UNCHANGED)
        if image is None:
            raise DataError(f"{file}, topic {topic}: an image of format {message.format} cannot be read.", file=file)
        suffix = ".png" if "png" in message.format.lower() else ".jpg"
        return suffix, bytes(message.data), (image.shape[1], image.shape[0])
    encoding = message.encoding
    if encoding not in CHANNEL_COUNTS and encoding not in BAYER:
        raise DataError(f"{file}, topic {topic}: no support for images of encoding {encoding!r}.", file=file)
    kind = np.dtype(np.uint16 if "16" in encoding else np.uint8).newbyteorder(">" if message.is_bigendian else "<")
    channels = CHANNEL_COUNTS.get(encoding, 1)
    data = np.asarray(message.data, dtype=np.uint8)
    if len(data) != message.step * message.height or message.step < message.width * channels * kind.itemsize:
        raise DataError(f"{file}, topic {topic}: an image has fewer bytes than its size says.", file=file)
    rows = data.reshape(message.height, message.step)[:, : message.width * channels * kind.itemsize]
    image = np.ascontiguousarray(rows).view(kind).astype(kind.newbyteorder("="))
    image = image.reshape(message.height, message.width, channels)
    if encoding in BAYER:
        image = cv2.cvtColor(image, getattr(cv2, f"COLOR_{BAYER[encoding]}2BGR"))
    elif encoding in ("rgb8", "rgba8"):
        image = image[..., [2, 1, 0]]
    elif channels == 4:
        image = image[..., :3]
    _, png = cv2.imencode(".png", image)
    return ".png", png.tobytes(), (message.width, message.height)
