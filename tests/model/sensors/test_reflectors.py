"""However many reflectors a tracker sees, each is found."""

import numpy as np
import pytest

from robolaser import calibrate
from robolaser.data.stated_noise import Noise
from robolaser.robot.by_name import find_robot
from robolaser.simulation import simulate


@pytest.mark.parametrize("reflectors", [1, 4, 9])
def test_every_reflector_of_a_tracker_is_calibrated(reflectors: int) -> None:
    made = simulate(
        find_robot("scorbot_er7"), kind="point", poses=60, points=reflectors, noise=Noise(point_m=1e-5), seed=3
    )
    found = calibrate(made.dataset).calibration
    assert len(found.x) == 6 + 3 * reflectors
    truth = np.array([made.truth[name] for name in found.model.parameters.names])
    places = [i for i, name in enumerate(found.model.parameters.names) if name.startswith("tool.")]
    np.testing.assert_allclose(found.x[places], truth[places], atol=3e-5)
