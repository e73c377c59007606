"""A calibrated camera as programs that know pinholes see it."""

from collections.abc import Callable
from dataclasses import dataclass
from typing import final

from robolaser.arrays import Array


@final
@dataclass(frozen=True)
class CameraView:
    """Where a camera's pixels look."""

    K: Array  # of the pinhole without distortion, (3, 3) [px]
    # pixels (p, 2) to x/z and y/z of what they show, x along image u and y along v, (p, 2)
    slopes: Callable[[Array], Array]
    distortion: Array | None = None  # OpenCV's k1, k2, p1, p2 and k3, where they are the camera's own, (5,)
