"""A calibrated camera as programs that know pinholes see it."""

from collections.abc import Callable
from dataclasses import dataclass
from typing import final

from robolaser.arrays import Array


@final
@dataclass(frozen=True)
class CameraView:
    """Where a camera's pixels look.

    Attributes:
        K: Of the pinhole without distortion, (3, 3) [px].
        slopes: Pixels (p, 2) to x/z and y/z of what they show, x along image u and y along v, (p, 2).
    """

    K: Array
    slopes: Callable[[Array], Array]
