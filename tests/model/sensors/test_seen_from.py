"""What a sensor would measure from other poses of the flange."""

from dataclasses import replace

import numpy as np
import pytest

from robolaser.data.dataset import Poses
from robolaser.geometry.robots import find_robot
from robolaser.geometry.visibility import random_configurations
from robolaser.model.forward_model import Model
from robolaser.simulation import simulate

ROBOT = find_robot("ur5")


@pytest.mark.parametrize("placed", [True, False])
def test_a_stripe_on_the_target_leaves_no_residual_from_wherever_it_is_seen(placed: bool) -> None:
    made = simulate(ROBOT, poses=12, points=8, placed=placed, seed=2)
    values = {name: np.array([value]) for name, value in made.truth.items()}
    q = made.dataset.poses.q + np.random.default_rng(0).normal(0.0, 0.02, (12, 6))
    points, good = Model(made.dataset).sensor.seen_from(values, ROBOT.forward(q[None])[0])
    assert good.any()
    there = Model(replace(made.dataset, poses=Poses(made.dataset.poses.names, q=q), points=points))
    left = np.abs(there.sensor.residuals({**values, "k": np.zeros(1)}, there.flange(values), there.perturb(values)))
    assert left.reshape(12, -1)[good].max() < 1e-9


def test_a_tracker_sees_each_reflector_from_every_pose() -> None:
    made = simulate(ROBOT, kind="point", poses=5, points=4, seed=2)
    q = random_configurations(ROBOT, 3, np.random.default_rng(0))
    points, good = Model(made.dataset).sensor.seen_from({}, ROBOT.forward(q[None])[0])
    assert points.names == ("0", "1", "2", "3") * 3
    np.testing.assert_array_equal(points.pose, np.repeat([0, 1, 2], 4))
    assert good.all()


def test_an_arm_in_a_socket_goes_nowhere_else() -> None:
    sensor = Model(simulate(ROBOT, kind="socket", poses=6, points=3).dataset).sensor
    assert sensor.seen_from({}, np.eye(4)[None]) is None
