"""What a fitted model says of the effects in it, where the data do not tell all of their parameters."""

from dataclasses import replace

import numpy as np
import pytest

from robolaser.data.stated_noise import Noise
from robolaser.diagnosis.fit import Fit, problem_of
from robolaser.diagnosis.preparation import Preparation
from robolaser.estimation.noise_estimate import noise_of
from robolaser.estimation.outliers import outliers_of
from robolaser.model.effects import candidate_effects
from robolaser.model.forward_model import Model
from robolaser.robot.by_name import find_robot
from robolaser.simulation import simulate


@pytest.fixture(scope="module")
def start() -> Fit:
    dataset = simulate(find_robot("ur5e"), kind="point", poses=30, points=3, noise=Noise(point_m=2e-5), seed=2).dataset
    return Preparation.of(dataset, 1).fit(())


def with_effect(start: Fit, name: str, size: float) -> Fit:
    """The model with an effect of that size, its other parameters nominal, not fitted again."""
    model = start.model.with_effects(candidate_effects((name,), start.model.dataset))
    own = model.effect_parameters.nominal.copy()
    own[0] = size
    return Fit(problem_of(model, start.noise, start.sensor), np.concatenate([start.x, own]))


def test_a_parameter_that_moves_no_row_does_not_make_an_effect_differ_from_zero(start: Fit) -> None:
    idle = with_effect(start, "transmission_error:elbow_joint", 0.0)
    assert (idle.deviations[-len(idle.model.effect_parameters) :] == 0.0).any()
    assert idle.wald(idle.effects[0]) == pytest.approx(0.0, abs=1e-9)


@pytest.mark.parametrize(("poses", "found"), [(2, 0), (30, 3)])
def test_poses_too_few_for_a_model_have_no_gross_errors_by_it(start: Fit, poses: int, found: int) -> None:
    some = start.model.dataset.of_poses(np.arange(len(start.model.dataset.poses)) < poses)
    xyz = some.points["xyz"].copy()
    xyz[:3, 0] += 0.01
    model = Model(replace(some, points=replace(some.points, xyz=xyz))).sharing(start.sensor)
    assert outliers_of(problem_of(model, noise_of(model, start.x), start.sensor), start.x).sum() == found


@pytest.mark.parametrize("side", [-1.0, 1.0])
def test_an_amplitude_on_its_bound_is_beyond_what_is_plausible_whatever_the_data_push(start: Fit, side: float) -> None:
    (effect,) = candidate_effects(("joint_offset:elbow_joint",), start.model.dataset)
    assert with_effect(start, "joint_offset:elbow_joint", side * 0.1).exceeds_bounds(effect)
    assert not with_effect(start, "joint_offset:elbow_joint", side * 0.09).exceeds_bounds(effect)


def test_an_effect_differs_from_zero_by_its_size_over_its_standard_deviation(start: Fit) -> None:
    fit = with_effect(start, "joint_offset:elbow_joint", 1e-3)
    assert fit.wald(fit.effects[0]) == pytest.approx((1e-3 / fit.deviations[-1]) ** 2)
