"""What carries a sensor that may be mounted either way: the flange, or the cell."""

from dataclasses import dataclass
from typing import Literal, final

from robolaser.data.dataset import Dataset


@final
@dataclass(frozen=True)
class Mounting:
    """Keys of `[sensor]`: where the sensor is mounted; what it measures is at the other end."""

    mount: Literal["flange", "base"] = "flange"


def stands(dataset: Dataset) -> bool:
    """Whether the sensor stands in the cell."""
    return getattr(dataset.options, "mount", "flange") == "base"
