"""A model's derivatives agree with differences of one parameter each."""

from dataclasses import replace

import numpy as np
import pytest

from robolaser.data.stated_noise import Noise
from robolaser.model.batches import with_rows
from robolaser.model.derivatives import jacobian
from robolaser.model.effects import candidate_effects
from robolaser.model.forward_model import Model
from robolaser.robot.by_name import find_robot
from robolaser.simulation import simulate


@pytest.mark.parametrize("kind", ["stripe", "camera", "point", "pose", "profile", "socket"])
@pytest.mark.parametrize("effects", [(), ("joint_offset:joint_2",)], ids=["bare", "with an effect"])
@pytest.mark.parametrize("rows", [None, 7], ids=["all rows", "some rows"])
def test_a_models_derivatives_are_those_of_each_parameter_by_itself(kind, effects, rows):
    dataset = simulate(find_robot("scorbot_er7"), kind=kind, poses=20, noise=Noise(), seed=1).dataset
    whole = Model(dataset, candidate_effects(effects, dataset))
    model = whole if rows is None else with_rows(whole, np.arange(rows))
    x, width = model.parameters.nominal, model.parameters.width
    J = jacobian(model, x[None])[0] * width[:, None, None]
    ahead, behind = (model.residuals(x + way * np.diag(3e-6 * width)) for way in (1, -1))
    expected = (ahead - behind) / 6e-6
    np.testing.assert_allclose(J, expected, rtol=1e-5, atol=1e-8 * np.abs(expected).max())


EVERY_STAGE = (
    "joint_offset:joint_2", "encoder_eccentricity:joint_2", "link_geometry:joint_2", "link_geometry:joint_3",
    "base_shift", "hand_eye_drift", "stripe_bias", "radial_distortion", "tangential_distortion", "laser_roll",
    "laser_drift", "laser_curvature", "target_scale", "target_warp",
)  # fmt: skip


@pytest.mark.parametrize("placed", [True, False])
def test_effects_at_all_stages_together_have_the_derivatives_of_the_whole_model(placed):
    dataset = simulate(find_robot("scorbot_er7"), poses=8, noise=Noise(), seed=1).dataset
    dataset = replace(dataset, placed=placed)
    model = Model(dataset, candidate_effects(EVERY_STAGE, dataset))
    rng, parameters = np.random.default_rng(0), model.parameters
    own = np.arange(len(parameters)) >= len(parameters) - len(model.effect_parameters)
    x = parameters.nominal + own * rng.uniform(-0.02, 0.02, (2, len(parameters))) * parameters.width
    x = np.clip(x, parameters.lower, parameters.upper)
    J = jacobian(model, x) * parameters.width[:, None, None]
    for one, found in zip(x, J, strict=True):
        ahead, behind = (model.residuals(one + way * np.diag(1e-5 * parameters.width)) for way in (1, -1))
        expected = (ahead - behind) / 2e-5
        np.testing.assert_allclose(found, expected, rtol=1e-5, atol=1e-6 * np.abs(expected).max())
