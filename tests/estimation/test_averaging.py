"""Repeats are averaged, and nothing else is."""

from dataclasses import replace

import numpy as np
from several import together

from robolaser import calibrate
from robolaser.data.stated_noise import Noise
from robolaser.estimation.averaging import AveragedData
from robolaser.simulation import CellOptions, simulate


def test_points_along_a_profile_are_no_repeats_because_a_tracker_beside_it_has_some() -> None:
    noise = Noise(point_m=3e-5)
    balls = simulate("ur5", kind="profile", poses=20, noise=noise, seed=1).dataset
    twice = CellOptions(repeats=2)
    shots = simulate("ur5", kind="point", poses=20, points=1, noise=noise, options=twice, seed=1).dataset
    pose, rng = shots.points.pose, np.random.default_rng(0)
    there = balls.flange()[pose, :3, :3] @ (0.05, 0.02, 0.1) + balls.flange()[pose, :3, 3]
    tracked = replace(shots.points, xyz=there + 3e-5 * rng.standard_normal(there.shape))
    both = together(balls, {"balls": (balls, balls.points), "tracker": (shots, tracked)})
    averaged = AveragedData.of(both)
    np.testing.assert_array_equal(averaged.shots, [1] * len(balls.points) + [2] * 20)
    assert calibrate(both, weights="noise").rms_m < 4e-5
