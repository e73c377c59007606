"""The corrected arm of a result is there however the result came about, and takes poses as people have them."""

from pathlib import Path

import numpy as np
import pytest

import robolaser
from robolaser.data.stated_noise import Noise
from robolaser.errors import UsageError
from robolaser.robot.by_name import find_robot
from robolaser.simulation import simulate

EFFECT = "joint_offset:elbow_joint"


@pytest.fixture(scope="module")
def dataset() -> robolaser.Dataset:
    noise = Noise(point_m=5e-5)
    return simulate(find_robot("ur5"), kind="point", poses=30, noise=noise, effects={EFFECT: 4e-3}, seed=1).dataset


@pytest.mark.parametrize("kind", ["calibration", "diagnosis"])
def test_a_saved_result_has_the_arm_that_it_had_when_it_was_made(
    kind: str, dataset: robolaser.Dataset, tmp_path: Path
) -> None:
    if kind == "calibration":
        made = robolaser.calibrate(dataset, effects=[EFFECT])
        made.save(tmp_path / kind)
        found = robolaser.load_calibration(tmp_path / kind)
    else:
        made = robolaser.diagnose(dataset, effects=["joint_offset"], seed=0)
        made.save(tmp_path / kind)
        found = robolaser.load_diagnosis(tmp_path / kind)
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
