"""Positions of a sensor's parts in the cell and on the flange, and the view of its camera."""

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
    """A camera's viewing rays, for programs that know pinholes."""

    K: Array  # of the pinhole without distortion, (3, 3) [px]
    slopes: Callable[[Array], Array]  # pixels (p, 2) to x/z and y/z of their rays, x along image u and y along v
    distortion: Array | None = None  # OpenCV's k1, k2, p1, p2 and k3, (5,); None for other lens models


@final
@dataclass(frozen=True)
class InCell:
    """A sensor in the cell, for one candidate.

    Attributes:
        flange: T_flange_frame (4, 4) of frames on the flange, by name: for exported files.
        base: T_base_frame (4, 4) of frames in the cell, by name.
        published: Names of frames with their own commands in ROS.
        mount: T_flange_sensor where the flange carries the sensor, (1, n or 1, 4, 4).
        stand: T_base_sensor of a camera in the cell, (1, 1, 4, 4).
        camera: None where it has none.
    """

    flange: Mapping[str, Array] = field(default_factory=dict)
    base: Mapping[str, Array] = field(default_factory=dict)
    published: Collection[str] = ()
    mount: Array | None = None
    stand: Array | None = None
    camera: CameraView | None = None


def is_static(dataset: Dataset) -> bool:
    """Whether the sensor is fixed in the cell."""
    return getattr(dataset.options, "mount", "flange") == "base"
