"""Data sets of several sensors, composed of one sensor's measurements."""

from collections.abc import Mapping
from dataclasses import replace

import numpy as np

from robolaser import find_robot
from robolaser.data.dataset import Dataset, Points, SensorData
from robolaser.data.several_sensors import with_points_of
from robolaser.data.stated_noise import Noise
from robolaser.geometry.rigid_motion import exp_so3, pose
from robolaser.simulation import simulate

T_RIGHT_LEFT = pose(exp_so3(np.array([0.1, 0.2, 1.0])), np.array([0.5, 1.0, 0.2]))


def two_trackers(poses: int = 20, *, effects: Mapping[str, float] | None = None, noise_m: float = 2e-5) -> Dataset:
    """Two trackers, `left` and `right`; the second sees two of the first's three reflectors."""
    noise = Noise(point_m=noise_m)
    left = simulate(find_robot("ur10"), kind="point", poses=poses, noise=noise, effects=effects, seed=3).dataset
    seen = left.points.take(np.isin(left.points.names, list(dict.fromkeys(left.points.names))[:2]))
    there = seen["xyz"] @ T_RIGHT_LEFT[:3, :3].T + T_RIGHT_LEFT[:3, 3]
    shaken = there + noise_m * np.random.default_rng(0).standard_normal(there.shape)
    return together(left, {"left": (left, left.points), "right": (left, replace(seen, xyz=shaken))})


def together(whole: Dataset, sensors: Mapping[str, tuple[Dataset, Points]]) -> Dataset:
    """One data set with the poses and the robot of the first, and these sensors with their measurements."""
    nothing = {"poses": whole.poses.take(np.arange(0)), "points": whole.points.take(slice(0, 0)), "parameters": {}}
    members = tuple(
        SensorData(name, replace(one, **nothing), f"{name}.csv", camera="camera") for name, (one, _) in sensors.items()
    )
    return with_points_of(replace(whole, members=members), [points for _, points in sensors.values()])
