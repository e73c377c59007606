"""A sensor's derivatives agree with differences."""

from dataclasses import replace

import numpy as np
import pytest
from differences import central_differences

from robolaser.data.stated_noise import Noise
from robolaser.model.derivatives import jacobian, jacobian_matrix
from robolaser.model.effects import candidate_effects
from robolaser.model.forward_model import Model
from robolaser.robot.by_name import find_robot
from robolaser.simulation import CellOptions, simulate

ROBOT = find_robot("ur5")
CELLS = {
    "stripe along u": simulate(ROBOT, poses=4, points=5),
    "stripe along v": simulate(
        ROBOT, poses=4, points=5, options=CellOptions(stripe_axis="v", bracket_quat=(0.1, 0.3, -0.2, 0.9))
    ),
    "unplaced target": simulate(ROBOT, poses=4, points=5, options=CellOptions(placed=False)),
    "tracker": simulate(ROBOT, kind="point", poses=8, points=4),
    "bodies": simulate(ROBOT, kind="pose", poses=8, points=2, noise=Noise(point_m=1e-3, angle_rad=0.3)),
    "profiles": simulate(ROBOT, kind="profile", poses=8, noise=Noise(point_m=1e-4)),
    "profiles of a standing sensor": simulate(
        ROBOT, kind="profile", poses=8, points=2, options=CellOptions(mount="base")
    ),
    "corners from the flange": simulate(ROBOT, kind="camera", poses=6),
    "corners from the cell": simulate(ROBOT, kind="camera", poses=6, options=CellOptions(mount="base")),
    "sockets": simulate(ROBOT, kind="socket", poses=6, points=3),
}


def numeric(model, x):
    """Derivatives of all numbers by differences, (K, d)."""

    def flat(shifts):
        return model.residuals(x + shifts).reshape(len(shifts), -1)

    small = 0.02 if model.dataset.kind == "profile" else 1.0  # as balls are beside boards
    step = 1e-5 * small * model.parameters.width
    return central_differences(flat, step)


def analytic(model: Model, x: np.ndarray) -> np.ndarray:
    """Derivatives of all numbers by the sensor's parameters, (K, d)."""
    J = jacobian_matrix(model, x)
    return J[:, : len(x) - len(model.effect_parameters)]


def near_the_truth(model: Model, truth: dict[str, float]) -> np.ndarray:
    x = np.array([truth[name] for name in model.parameters.names])
    return x + 0.01 * model.parameters.width * np.random.default_rng(0).uniform(-1, 1, len(x))


@pytest.mark.parametrize("name", CELLS)
def test_columns_of_the_parameters_agree_with_differences(name):
    made = CELLS[name]
    model = Model(made.dataset)
    x = near_the_truth(model, dict(made.truth))
    slopes, expected = analytic(model, x), numeric(model, x)
    assert slopes.shape == (len(made.dataset.points) * model.blocks.sensor.format.numbers, len(x))
    largest = np.abs(expected).max(axis=0)
    assert np.abs(slopes - expected).max(axis=0) == pytest.approx(np.zeros(len(x)), abs=1e-7 * largest.max())
    assert (np.abs(slopes - expected).max(axis=0) <= 1e-7 * largest).all()


def test_angles_in_the_order_of_the_paper_agree_too():
    made = CELLS["stripe along u"]
    model = Model(replace(made.dataset, angles="zyz"))
    x = near_the_truth(model, dict(made.truth))
    expected = numeric(model, x)
    np.testing.assert_allclose(analytic(model, x), expected, atol=1e-7 * np.abs(expected).max())


@pytest.mark.parametrize(
    ("name", "effect"),
    [("stripe along u", "joint_compliance:joint_2"), ("stripe along u", "target_scale"), ("tracker", "base_shift")],
)
def test_effects_that_come_before_or_after_the_sensors_chain_change_nothing_of_that(name, effect):
    made = CELLS[name]
    names = ROBOT.joints
    at = effect.replace("joint_2", names[1])
    model = Model(made.dataset, candidate_effects([at], made.dataset))
    sizes = {item.name: 0.3 * item.upper for item in model.effect_parameters.items}
    x = near_the_truth(model, dict(made.truth) | sizes)
    count = len(x) - len(model.effect_parameters)
    expected = numeric(model, x)[:, :count]
    np.testing.assert_allclose(analytic(model, x), expected, atol=1e-7 * np.abs(expected).max())


def test_candidates_are_worked_out_side_by_side():
    made = CELLS["unplaced target"]
    model = Model(made.dataset)
    batch = np.stack([near_the_truth(model, dict(made.truth)), model.parameters.nominal])
    for one, slopes in zip(batch, jacobian(model, batch), strict=True):
        np.testing.assert_allclose(slopes, jacobian(model, one[None])[0], rtol=1e-12, atol=1e-12)
