"""What says how an effect acts is found by trying it, where the way downhill leads elsewhere."""

import numpy as np
import pytest

from robolaser.calibration.calibrate import calibrate
from robolaser.calibration.plan import Plan
from robolaser.data.stated_noise import Noise
from robolaser.estimation.nonlinear_parameters import initialize_effects, with_nonlinear_grid
from robolaser.estimation.problem import Problem
from robolaser.estimation.solver import solve
from robolaser.model.effects import candidate_effects
from robolaser.model.effects.run import Run
from robolaser.model.forward_model import Model
from robolaser.robot.by_name import find_robot
from robolaser.simulation import Simulated, simulate

NOISE = Noise(point_m=2e-5)


def tracked(effects: dict[str, float]) -> Simulated:
    return simulate(find_robot("scorbot_er7"), kind="point", poses=40, points=3, noise=NOISE, effects=effects, seed=1)


@pytest.mark.parametrize("moment", [0.12, 0.81])
def test_a_knock_is_found_in_the_pause_in_which_it_happened(moment: float) -> None:
    made = tracked({"base_shift:base": 1e-3, "base_shift:base.moment": moment})
    found = calibrate(made.dataset, Plan(effects=("base_shift",)))
    progress = Run(made.dataset).progress
    np.testing.assert_array_equal(progress > found.value("base_shift.base.moment"), progress > moment)
    assert found.value("base_shift.base.x") == pytest.approx(1e-3, abs=5e-5)


def test_a_knocks_moment_has_no_standard_error_within_its_pause() -> None:
    found = calibrate(tracked({"base_shift:base": 1e-3}).dataset, Plan(effects=("base_shift",)))
    std = dict(zip(found.model.parameters.names, found.std, strict=True))
    assert np.isnan(std["base_shift.base.moment"])
    assert std["base_shift.base.x"] < 2e-5
    assert ("base_shift.base.moment",) in [one.parameters for one in found.unidentifiable]


@pytest.mark.parametrize("cycles", [31.0, 163.0])
def test_the_gear_that_errs_is_found_by_its_number_of_cycles(cycles: float) -> None:
    at = "transmission_error:joint_2"
    made = tracked({at: 6e-4, f"{at}.cosine_2": 4e-4, f"{at}.cycles": cycles})
    found = calibrate(made.dataset, Plan(effects=(at,)))
    assert found.value("transmission_error.joint_2.cycles") == pytest.approx(cycles, abs=0.05)
    assert found.value("transmission_error.joint_2.sine") == pytest.approx(6e-4, abs=5e-5)
    assert found.rms_m < 4e-5


def test_waves_of_two_joints_are_not_taken_for_one_anothers() -> None:
    first, second = "transmission_error:joint_1", "transmission_error:joint_2"
    made = tracked({first: 6e-4, f"{first}.cycles": 47.0, second: 9e-4, f"{second}.cycles": 110.0})
    plain = Model(made.dataset)
    x = solve(Problem.of(plain), plain.parameters.nominal[None]).x[0]
    sought = with_nonlinear_grid(Model(made.dataset, candidate_effects([first, second], made.dataset)))
    values = initialize_effects(plain, x, sought)
    for joint, cycles in (("joint_1", 47.0), ("joint_2", 110.0)):
        near = values[f"transmission_error.{joint}.cycles"] / cycles
        assert near == pytest.approx(1.0, abs=0.02) or near == pytest.approx(0.5, abs=0.02)


def test_shapes_are_chosen_within_the_bounds_of_their_effects() -> None:
    made = tracked({"base_shift:base": 0.015, "base_shift:base.moment": 0.3})
    plain = Model(made.dataset)
    sought = candidate_effects(["base_shift", "transmission_error:joint_2", "backlash:joint_3"], made.dataset)
    values = initialize_effects(plain, plain.parameters.nominal, sought)
    for candidate_effect in sought:
        for item in candidate_effect.parameters.items:
            assert item.lower <= values[item.name] <= item.upper
