"""The corrected arm of a result is there however the result came about, and takes poses as people have them."""

from pathlib import Path

import numpy as np
import pytest
from few_files import only

import robolaser
from robolaser.data.stated_noise import Noise
from robolaser.errors import UsageError
from robolaser.robot.by_name import find_robot
from robolaser.simulation import simulate


def test_a_saved_diagnosis_has_the_arm_that_it_had_when_it_was_made(tmp_path: Path) -> None:
    noise, effects = Noise(point_m=5e-5), {"joint_offset:elbow_joint": 4e-3}
    dataset = simulate(find_robot("ur5"), kind="point", poses=20, noise=noise, effects=effects, seed=1).dataset
    with only("robot_corrected.urdf"):
        made = robolaser.diagnose(dataset, effects=["joint_offset"], seed=0)
        made.save(tmp_path / "found")
    found = robolaser.load_diagnosis(tmp_path / "found")
    q = dataset.poses.q
    np.testing.assert_allclose(found.robot.forward(q), made.robot.forward(q), atol=1e-9)
    assert np.abs(made.robot.forward(q) - dataset.robot.forward(q)).max() > 1e-3
    assert "robot" in dir(found)


def test_poses_may_have_fewer_axes() -> None:
    robot = find_robot("ur5")
    q = np.random.default_rng(0).uniform(-1.0, 1.0, (5, 6))
    (T,), (J,) = robot.forward(q[None]), robot.jacobian(q[None])
    np.testing.assert_array_equal(robot.forward(q), T)
    np.testing.assert_array_equal(robot.forward(q[2].tolist()), T[2])
    np.testing.assert_array_equal(robot.jacobian(q), J)
    np.testing.assert_array_equal(robot.jacobian(q[2].tolist()), J[2])


def test_a_value_too_few_is_said() -> None:
    with pytest.raises(UsageError, match="5 joint values for each pose, but ur5 has 6 joints"):
        find_robot("ur5").forward(np.zeros((3, 5)))
