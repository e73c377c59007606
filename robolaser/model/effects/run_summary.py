"""The summary of a run that is needed to apply its effects to another one."""

import hashlib
from dataclasses import dataclass
from typing import Annotated, final

import numpy as np
from msgspec import Meta

from robolaser.data.dataset import Dataset
from robolaser.model.effects.run import Course, Run


@final
@dataclass(frozen=True)
class RunSummary:
    """The run that a calibration was made from."""

    poses: Annotated[int, Meta(ge=1)]  # number of poses
    sha256: str  # digest of names, readings and times: identifies a run with the same poses
    # middle of all flanges by the nominal arm, about which `base_shift` turns, (3,) [m]
    middle_m: Annotated[list[float], Meta(min_length=3, max_length=3)]
    # the lowest and highest temperature [°C]; None where it was not measured
    temperature_c: Annotated[list[float], Meta(min_length=2, max_length=2)] | None

    @classmethod
    def of(cls, dataset: Dataset) -> "RunSummary":
        """The run in which a data set was measured."""
        poses = dataset.poses
        digest = hashlib.sha256("\0".join(poses.names).encode())
        for numbers in (poses.time_s, poses.q, poses.T_base_flange):
            digest.update(b"" if numbers is None else np.ascontiguousarray(numbers, "<f8").tobytes())
        read = poses.temperature_c
        return cls(
            poses=len(poses),
            sha256=digest.hexdigest(),
            middle_m=dataset.flange()[:, :3, 3].mean(axis=0).tolist(),
            temperature_c=None if read is None else [float(read.min()), float(read.max())],
        )


def continued(summary: RunSummary | None, dataset: Dataset) -> Run:
    """Another data set as a later part of a run, of which nothing may be known.

    All its poses count as taken at the end of that run, warmed up, or by temperatures where both have them.
    """
    n = len(dataset.poses)
    low, high = [0.0, 0.0] if summary is None or summary.temperature_c is None else summary.temperature_c
    read = dataset.poses.temperature_c
    rise = None if low == high else np.ones(n) if read is None else (read - low) / (high - low)
    return Run(dataset, Course(np.ones(n), rise, by_thermometer=rise is not None and read is not None))
