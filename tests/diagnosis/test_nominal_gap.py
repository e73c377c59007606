"""What counts as the nominal model: the sim as somebody gave it, never what was found from the data."""

from dataclasses import replace

import numpy as np
import pytest

from robolaser.data.stated_noise import Noise
from robolaser.diagnosis.findings import gap_of
from robolaser.diagnosis.fit import Fit, problem_of
from robolaser.diagnosis.held_out_gap import HeldOut
from robolaser.estimation.averaging import AveragedData
from robolaser.estimation.noise_estimate import NoiseEstimate
from robolaser.model.forward_model import Model
from robolaser.robot.by_name import find_robot
from robolaser.simulation import simulate

NOISE = Noise(pixel_px=0.1, target_m=3e-5, joint_rad=1e-5, point_m=2e-5)


def gap(kind, unknown=()):
    """Of a healthy cell whose data set does not give the parameters that begin so."""
    made = simulate(find_robot("scorbot_er7"), kind=kind, poses=12, points=4, noise=NOISE, seed=3).dataset
    items = {name: replace(one, given=not name.startswith(unknown)) for name, one in made.parameters.items()}
    made = replace(made, parameters=items)
    data = AveragedData.of(made)
    model = Model(data.dataset)
    x = model.parameters.nominal
    noise = NoiseEstimate.of(data, model, x).for_weights()
    start = Fit.of(problem_of(model, noise, model.parameters), x)
    return gap_of(start, start, noise, HeldOut(start, 0), 0)


def test_a_scanner_that_was_given_is_the_nominal_model():
    assert gap("stripe", ("nothing",)).nominal_m > 0


@pytest.mark.parametrize("unknown", [("",), ("f", "s_u"), ("w", "phi", "psi", "t_")])
def test_a_scanner_of_which_something_was_found_from_the_data_has_no_nominal_model(unknown):
    assert gap("stripe", unknown).nominal_m is None


def test_an_arm_before_a_tracker_that_nobody_placed_is_the_nominal_model_on_new_poses():
    found = gap("point")
    assert found.nominal_m == found.calibrated_m
    assert np.isfinite(found.nominal_m)
