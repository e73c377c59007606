"""What of a run must be known to apply the effects found in it to another one."""

import hashlib
from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any, final

import numpy as np

from robolaser.data.dataset import Dataset
from robolaser.model.effects.course import temperature


@final
@dataclass(frozen=True)
class Run:
    """The poses of a run in a few numbers.

    Attributes:
        poses: How many.
        sha256: Of their names, readings and times: the same poses or not.
        middle_m: Middle of all flanges by the nominal arm, about which `base_shift` turns, (3,) [m].
        temperature_c: The lowest and highest that were read, between which what warms up is counted [°C]; None where
            no thermometer was.
    """

    poses: int
    sha256: str
    middle_m: tuple[float, float, float]
    temperature_c: tuple[float, float] | None

    @classmethod
    def of(cls, dataset: Dataset) -> "Run":
        """The run in which a data set was measured."""
        poses = dataset.poses
        told = hashlib.sha256("\0".join(poses.names).encode())
        for numbers in (poses.time_s, poses.q, poses.T_base_flange):
            told.update(b"" if numbers is None else np.ascontiguousarray(numbers, "<f8").tobytes())
        read = temperature(poses)
        x, y, z = dataset.flange()[:, :3, 3].mean(axis=0).tolist()
        return cls(
            poses=len(poses),
            sha256=told.hexdigest(),
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
