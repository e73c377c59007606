"""What must be known of a run to apply the effects found in it to another one."""

import hashlib
from collections.abc import Mapping
from dataclasses import dataclass
from typing import Annotated, Any, final

import numpy as np
from msgspec import Meta

from robolaser.data.dataset import Dataset
from robolaser.model.effects.run import Course, Run


@final
@dataclass(frozen=True)
class RunSummary:
    """The run that a calibration was made from."""

    poses: Annotated[int, Meta(ge=1)]  # number of poses
    sha256: str  # of their names, readings and times: tells whether another run has the same poses
    # middle of all flanges by the nominal arm, about which `base_shift` turns, (3,) [m]
    middle_m: tuple[float, float, float]
    # the lowest and highest temperature [°C]; None where it was not measured
    temperature_c: tuple[float, float] | None

    @classmethod
    def of(cls, dataset: Dataset) -> "RunSummary":
        """The run in which a data set was measured."""
        poses = dataset.poses
        digest = hashlib.sha256("\0".join(poses.names).encode())
        for numbers in (poses.time_s, poses.q, poses.T_base_flange):
            digest.update(b"" if numbers is None else np.ascontiguousarray(numbers, "<f8").tobytes())
        read = poses.temperature_c
        x, y, z = dataset.flange()[:, :3, 3].mean(axis=0).tolist()
        return cls(
            poses=len(poses),
            sha256=digest.hexdigest(),
            middle_m=(x, y, z),
            temperature_c=None if read is None else (float(read.min()), float(read.max())),
        )

    def as_json(self) -> Mapping[str, Any]:
        """What calibration.json holds of it."""
        return {
            "poses": self.poses,
            "sha256": self.sha256,
            "middle_m": list(self.middle_m),
            "temperature_c": None if self.temperature_c is None else list(self.temperature_c),
        }


def continued(summary: RunSummary | None, dataset: Dataset) -> Run:
    """Another data set as a later part of a run, of which nothing may be known.

    All its poses count as taken at the end of that run, warmed up; where both have temperatures, these say how warm.
    """
    n = len(dataset.poses)
    low, high = (0.0, 0.0) if summary is None or summary.temperature_c is None else summary.temperature_c
    read = dataset.poses.temperature_c
    rise = None if low == high else np.ones(n) if read is None else (read - low) / (high - low)
    return Run(dataset, Course(np.ones(n), rise, by_thermometer=rise is not None and read is not None))
