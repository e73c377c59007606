"""The noise that a data set states."""

from dataclasses import dataclass
from typing import final

import numpy as np

from robolaser.data.toml_schema import Positive


@final
@dataclass(frozen=True)
class Noise:
    """Known standard deviations per axis; None: to be estimated."""

    pixel_px: Positive | None = None  # of a pixel
    target_m: Positive | None = None  # of a target point; its repeats share one error
    joint_rad: Positive | None = None  # of a joint reading
    joint_step_rad: Positive | None = None  # resolution of a joint reading: a uniform error beside that of `joint_rad`
    # repeatability of the arm's flange by its data sheet (ISO 9283); no standard deviation, but a limit: scatter of
    # whole poses beyond it is a gap
    repeatability_m: Positive | None = None
    point_m: Positive | None = None  # of a tracker's point, of a 6-D pose's place, of a profile's point
    angle_rad: Positive | None = None  # of a 6-D pose's rotation, about each axis
    distance_m: Positive | None = None  # of the known distances

    @property
    def rounding_rad(self) -> float:
        """Standard deviation of a joint reading by its steps alone [rad]: that of a uniform error."""
        return float(self.joint_step_rad or 0.0) / float(np.sqrt(12.0))

    @property
    def reading_rad(self) -> float | None:
        """Stated standard deviation of a joint reading [rad]; None where only its steps are stated."""
        return None if self.joint_rad is None else float(np.hypot(self.joint_rad, self.rounding_rad))
