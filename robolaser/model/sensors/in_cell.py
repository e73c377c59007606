"""Where the parts of a sensor are in the cell and on the flange, and what its camera sees."""

from collections.abc import Callable, Collection, Mapping
from dataclasses import dataclass, field
from typing import final

from robolaser.arrays import Array
from robolaser.data.dataset import Dataset
from robolaser.data.sensor_format import Mount


@final
@dataclass(frozen=True)
class Mounting:
    """Keys of `[sensor]`: where the sensor is mounted; what it measures is at the other end."""

    mount: Mount = "flange"


@final
@dataclass(frozen=True)
class CameraView:
    """Where a camera's pixels look, as programs that know pinholes see it."""

    K: Array  # of the pinhole without distortion, (3, 3) [px]
    slopes: Callable[[Array], Array]  # pixels (p, 2) to x/z and y/z of what they show, x along image u and y along v
    distortion: Array | None = None  # OpenCV's k1, k2, p1, p2 and k3, (5,); None where the lens is another one


@final
@dataclass(frozen=True)
class InCell:
    """A sensor in the cell, for one candidate.

    Attributes:
        flange: T_flange_frame (4, 4) of what sits on the flange, by name: frames of exported files.
        base: T_base_frame (4, 4) of what stands in the cell, by name.
        published: Names of those that ROS is told of by commands of their own.
        mount: T_flange_sensor where the flange carries the sensor, (1, n or 1, 4, 4).
        stand: T_base_sensor where a camera stands in the cell, (1, 1, 4, 4).
        camera: None where it has none.
    """

    flange: Mapping[str, Array] = field(default_factory=dict)
    base: Mapping[str, Array] = field(default_factory=dict)
    published: Collection[str] = ()
    mount: Array | None = None
    stand: Array | None = None
    camera: CameraView | None = None


def stands(dataset: Dataset) -> bool:
    """Whether the sensor stands in the cell."""
    return getattr(dataset.options, "mount", "flange") == "base"
