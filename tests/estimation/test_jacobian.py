"""Derivatives of a model's residuals are those of each parameter by itself, however many are moved at once."""

import numpy as np
import pytest

from robolaser.arrays import Array
from robolaser.data.dataset import Noise
from robolaser.estimation.jacobian import jacobian
from robolaser.geometry.robots import find_robot
from robolaser.model.effects import candidate_effects
from robolaser.model.forward_model import Model
from robolaser.model.pose_blocks import with_rows
from robolaser.simulation import simulate


def one_by_one(model: Model, x: Array) -> Array:
    step = 1e-5 * model.parameters.width
    ahead, behind = (model.residuals(x + way * np.diag(step)).reshape(len(x), -1) for way in (1, -1))
    slopes: Array = ((ahead - behind) / (2 * step)[:, None]).T
    return slopes


@pytest.mark.parametrize("kind", ["stripe", "point", "socket"])
@pytest.mark.parametrize("effects", [(), ("joint_offset:joint_2",)], ids=["bare", "with an effect"])
@pytest.mark.parametrize("rows", [None, 7], ids=["all rows", "some rows"])
def test_parameters_moved_together_have_the_derivatives_of_each(
    kind: str, effects: tuple[str, ...], rows: int | None
) -> None:
    dataset = simulate(find_robot("scorbot_er7"), kind=kind, poses=20, noise=Noise(), seed=1).dataset
    whole = Model(dataset, candidate_effects(effects, dataset))
    model = whole if rows is None else with_rows(whole, np.arange(rows))
    J = jacobian(model, model.parameters.nominal)
    expected = one_by_one(model, model.parameters.nominal)
    scale = model.parameters.width
    np.testing.assert_allclose(J * scale, expected * scale, rtol=1e-5, atol=1e-8 * np.abs(expected * scale).max())


@pytest.mark.parametrize("kind", ["point", "socket"])
def test_no_row_depends_on_two_parameters_that_are_apart(kind: str) -> None:
    model = Model(simulate(find_robot("scorbot_er7"), kind=kind, poses=20, noise=Noise(), seed=1).dataset)
    J = one_by_one(model, model.parameters.nominal).reshape(-1, 3, len(model.parameters))
    assert model.sensor.separable
    for names, of_row in model.sensor.separable:
        touched = np.abs(J[:, :, model.parameters.columns(names)]).max(axis=1) > 1e-9
        assert (touched.sum(axis=1) == 1).all()
        assert np.array_equal(np.argmax(touched, axis=1), of_row)
