"""Where the parts of a sensor are in the cell and on the flange, and what its camera sees."""

from collections.abc import Callable, Collection, Mapping
from dataclasses import dataclass, field
from typing import final

from robolaser.arrays import Array


@final
@dataclass(frozen=True)
class CameraView:
    """Where a camera's pixels look, as programs that know pinholes see it."""

    K: Array  # of the pinhole without distortion, (3, 3) [px]
    # pixels (p, 2) to x/z and y/z of what they show, x along image u and y along v, (p, 2)
    slopes: Callable[[Array], Array]
    distortion: Array | None = None  # OpenCV's k1, k2, p1, p2 and k3, where they are the camera's own, (5,)


@final
@dataclass(frozen=True)
class InCell:
    """A sensor in the cell, for one candidate."""

    flange: Mapping[str, Array] = field(default_factory=dict)  # T_flange_frame of what sits on the flange, by name
    base: Mapping[str, Array] = field(default_factory=dict)  # T_base_frame of what stands in the cell, by name
    published: Collection[str] = ()  # frames that ROS is told of by commands of their own
    mount: Array | None = None  # T_flange_sensor where the flange carries the sensor, (1, n or 1, 4, 4)
    stand: Array | None = None  # T_base_sensor where a camera stands in the cell, (1, 1, 4, 4)
    camera: CameraView | None = None
