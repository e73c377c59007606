"""Frames of a sensor in the cell and on the flange, which exported files have."""

from collections.abc import Collection, Mapping
from dataclasses import dataclass, field
from typing import final

from robolaser.arrays import Array


@final
@dataclass(frozen=True)
class CellFrames:
    """Where things sit, by name, for one candidate."""

    flange: Mapping[str, Array] = field(default_factory=dict)  # T_flange_frame of what sits on the flange
    base: Mapping[str, Array] = field(default_factory=dict)  # T_base_frame of what stands in the cell
    published: Collection[str] = ()  # those that ROS is told of by commands of their own
