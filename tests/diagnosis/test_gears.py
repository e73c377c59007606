"""A gear's waves are told at the frequency of the first of them."""

from dataclasses import replace

import numpy as np
import pytest
from worlds import kinds

from robolaser.data.stated_noise import Noise
from robolaser.diagnosis import examine
from robolaser.robot.by_name import find_robot
from robolaser.simulation import simulate


@pytest.mark.parametrize(("cycles", "twice"), [(20, 0.0), (80, 3e-4), (160, 0.0)])
def test_one_wave_of_a_gear_is_no_second_harmonic_of_half_its_frequency(cycles: int, twice: float) -> None:
    made = simulate(find_robot("ur5e"), kind="point", poses=60, noise=Noise(point_m=2e-5, joint_rad=1e-5), seed=5)
    dataset = made.dataset
    q = dataset.poses.q.copy()
    phase = cycles * q[:, 2] + 1.0
    q[:, 2] -= 4e-4 * np.sin(phase) + twice * np.cos(2.0 * phase)
    suspects = kinds("transmission_error", "encoder_eccentricity", "joint_offset", "joint_coupling", "settling")
    (one,) = examine(replace(dataset, poses=replace(dataset.poses, q=q)), suspects, seed=1).findings
    assert str(one.candidate_effect) == "transmission_error at elbow_joint"
    values = {name: estimate.value for name, estimate in one.parameters.items()}
    assert values["cycles"] == pytest.approx(cycles, abs=0.1)
    assert np.hypot(values["sine"], values["cosine"]) == pytest.approx(4e-4, rel=0.1)
    assert np.hypot(values["sine_2"], values["cosine_2"]) == pytest.approx(twice, abs=4e-5)
