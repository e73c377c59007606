"""The noise that a data set states."""

from dataclasses import dataclass
from typing import final

import numpy as np

from robolaser.data.toml_schema import Positive


@final
@dataclass(frozen=True)
class Noise:
    """Known standard deviations per axis; None: to be estimated.

    Attributes:
        pixel_px: Of a pixel.
        target_m: Of a target point; its repeats share one error.
        joint_rad: Of a joint reading.
        joint_step_rad: Resolution of a joint reading: a uniform error in addition to that of `joint_rad`.
        repeatability_m: Repeatability of the arm's flange by its data sheet (ISO 9283); no
            standard deviation, but a limit: scatter of whole poses beyond it is a gap.
        point_m: Of a tracker's point, of a 6-D pose's place, of a profile's point.
        angle_rad: Of a 6-D pose's rotation, about each axis.
        distance_m: Of the known distances.
    """

    pixel_px: Positive | None = None
    target_m: Positive | None = None
    joint_rad: Positive | None = None
    joint_step_rad: Positive | None = None
    repeatability_m: Positive | None = None
    point_m: Positive | None = None
    angle_rad: Positive | None = None
    distance_m: Positive | None = None

    @property
    def rounding_rad(self) -> float:
        """Standard deviation of a joint reading by its steps alone [rad]: that of a uniform error."""
        return float(self.joint_step_rad or 0.0) / float(np.sqrt(12.0))

    @property
    def reading_rad(self) -> float | None:
        """Stated standard deviation of a joint reading [rad]; None where only its steps are stated."""
        return None if self.joint_rad is None else float(np.hypot(self.joint_rad, self.rounding_rad))
