"""Derivatives agree with closed forms, also at bounds and beside poles, and with differences of one parameter each."""

import numpy as np
import pytest

from robolaser.data.dataset import Noise
from robolaser.geometry.robots import find_robot
from robolaser.model.derivatives import differences, jacobian
from robolaser.model.effects import candidate_effects
from robolaser.model.forward_model import Model
from robolaser.model.pose_blocks import with_rows
from robolaser.simulation import simulate

T = np.linspace(0.0, 3.0, 40)
LOWER, UPPER, SCALE = np.array([0.0, 0.0, -1.0]), np.array([5.0, 2.0, 1.0]), np.array([1.0, 2.0, 10.0])


def decay(x):
    return x[:, :1] * np.exp(-x[:, 1:2] * T) + x[:, 2:3]


def slopes_of(x):
    fading = np.exp(-x[1] * T)
    return np.stack([fading, -x[0] * T * fading, np.ones_like(T)])


def by_differences(function, *x, columns=(0, 1, 2)):
    return differences(function, np.array(x), 1e-5 * SCALE, np.array(columns), LOWER, UPPER)


def test_derivatives_agree_with_the_closed_form_also_at_bounds():
    x = [0.0, 2.0, 1.0], [5.0, 0.0, -1.0], [1.0, 1.0, 0.0]
    for at, J in zip(x, by_differences(decay, *x), strict=True):
        np.testing.assert_allclose(J, slopes_of(at), atol=1e-7)


def test_derivatives_come_from_the_side_without_a_pole():
    def walled(x):
        return np.where(x[:, :1] > 1.0, np.nan, decay(x))

    assert by_differences(walled, [1.0, 1.0, 0.0])[0] == pytest.approx(slopes_of([1.0, 1.0, 0.0]), abs=1e-4)


def test_between_two_poles_a_derivative_is_zero():
    def alone(x):
        return np.where(x[:, :1] == 1.0, decay(x), np.nan)

    assert np.all(by_differences(alone, [1.0, 1.0, 0.0])[0, 0] == 0.0)


def test_only_the_columns_asked_for_are_differentiated():
    both = by_differences(decay, [1.0, 1.0, 0.0], columns=(0, 2))
    assert both.shape == (1, 2, len(T))
    np.testing.assert_allclose(both[0], slopes_of([1.0, 1.0, 0.0])[[0, 2]], atol=1e-7)


def test_a_batch_is_never_larger_than_memory_should_bear(monkeypatch):
    whole = by_differences(decay, [1.0, 1.0, 0.0])
    monkeypatch.setattr("robolaser.model.derivatives.BATCH", 3 * len(T))

    def watched(x):
        assert len(x) <= 3
        return decay(x)

    np.testing.assert_array_equal(by_differences(watched, [1.0, 1.0, 0.0]), whole)


@pytest.mark.parametrize("kind", ["stripe", "point", "socket"])
@pytest.mark.parametrize("effects", [(), ("joint_offset:joint_2",)], ids=["bare", "with an effect"])
@pytest.mark.parametrize("rows", [None, 7], ids=["all rows", "some rows"])
def test_a_models_derivatives_are_those_of_each_parameter_by_itself(kind, effects, rows):
    dataset = simulate(find_robot("scorbot_er7"), kind=kind, poses=20, noise=Noise(), seed=1).dataset
    whole = Model(dataset, candidate_effects(effects, dataset))
    model = whole if rows is None else with_rows(whole, np.arange(rows))
    x, width = model.parameters.nominal, model.parameters.width
    J = jacobian(model, x[None])[0] * width[:, None, None]
    ahead, behind = (model.residuals(x + way * np.diag(3e-5 * width)) for way in (1, -1))
    expected = (ahead - behind) / 6e-5
    np.testing.assert_allclose(J, expected, rtol=1e-5, atol=1e-8 * np.abs(expected).max())
