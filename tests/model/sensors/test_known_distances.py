"""Distances that are known beforehand are rows of every fit."""

from dataclasses import replace

import numpy as np
import pytest

from robolaser.calibration.calibrate import calibrate
from robolaser.calibration.plan import Plan
from robolaser.calibration.result import Calibration
from robolaser.data.dataset import Dataset
from robolaser.data.stated_noise import Noise
from robolaser.model.forward_model import Model
from robolaser.robot.by_name import find_robot
from robolaser.simulation import simulate

ROBOT = find_robot("ur5")
SOCKETS = simulate(ROBOT, kind="socket", poses=20, points=3, noise=Noise(joint_rad=2e-4), seed=1).dataset
TRACKER = simulate(ROBOT, kind="point", poses=20, points=4, noise=Noise(point_m=1e-4), seed=1).dataset


def apart(found: Calibration, dataset: Dataset) -> list[float]:
    """Distances of the points that the data set's pairs name, by a calibration [m]."""
    value = dict(zip(found.model.parameters.names, found.x, strict=True))
    prefix = "socket" if "socket.0.x" in value else "tool"
    return [
        float(np.linalg.norm([value[f"{prefix}.{a}.{i}"] - value[f"{prefix}.{b}.{i}"] for i in "xyz"]))
        for a, b, _ in dataset.distances_m
    ]


def stated(dataset: Dataset, distance: float, sigma_m: float | None = None) -> Dataset:
    noise = replace(dataset.noise, distance_m=sigma_m)
    return replace(dataset, distances_m=(("0", "1", distance),), noise=noise)


def test_their_rows_are_known_less_modelled_over_their_standard_deviation():
    model = Model(stated(SOCKETS, 0.2, 1e-4))
    x = np.random.default_rng(0).normal(size=(2, len(model.parameters)))
    values = model.parameters.values(x)
    length = np.linalg.norm([values[f"socket.0.{i}"] - values[f"socket.1.{i}"] for i in "xyz"], axis=0)
    np.testing.assert_allclose(model.extra_residuals(x), (0.2 - length)[:, None] / 1e-4)


def test_without_any_there_are_no_such_rows():
    model = Model(replace(SOCKETS, distances_m=()))
    assert model.known_distances is None
    assert model.extra_residuals(model.parameters.nominal[None]).shape == (1, 0)


def test_their_derivatives_agree_with_differences():
    model = Model(SOCKETS)
    x = model.parameters.nominal + 0.01
    known, names = model.known_distances, model.parameters.names
    slopes = known.jacobian(model.parameters.values(x[None]), names)[0]
    for column, step in enumerate(1e-6 * np.eye(len(x))):
        up, down = (known.residuals(model.parameters.values((x + way * step)[None]))[0] for way in (1, -1))
        np.testing.assert_allclose(slopes[:, column], (up - down) / 2e-6, atol=1e-8)


@pytest.mark.parametrize("weights", ["plain", "noise"])
@pytest.mark.parametrize("dataset", [SOCKETS, TRACKER], ids=["sockets", "tracker"])
def test_a_calibration_keeps_to_a_distance_as_its_noise_says(dataset: Dataset, weights: str):
    plan = Plan(weights=weights)
    free = calibrate(replace(dataset, distances_m=()), plan)
    here = apart(free, stated(dataset, 0.1))[0]
    wanted = here + 1e-3
    firmly = calibrate(stated(dataset, wanted, 1e-6), plan)
    assert apart(firmly, stated(dataset, wanted))[0] == pytest.approx(wanted, abs=1e-5)
    loosely = calibrate(stated(dataset, wanted, 1.0), plan)
    assert apart(loosely, stated(dataset, wanted))[0] == pytest.approx(here, abs=1e-6)
    assert firmly.objective_m2 > free.objective_m2


def test_a_distance_ten_times_too_long_changes_the_answer_visibly():
    one, other, known = SOCKETS.distances_m[0]
    told = calibrate(SOCKETS)
    wrong = calibrate(replace(SOCKETS, distances_m=((one, other, 10 * known),)))
    assert apart(told, SOCKETS)[0] == pytest.approx(known, abs=3e-4)
    assert apart(wrong, SOCKETS)[0] > 2 * known
    assert wrong.objective_m2 > 100 * told.objective_m2
    said = f"The known distance between {one} and {other} is"
    assert [any(warning.startswith(said) for warning in found.warnings) for found in (told, wrong)] == [False, True]
