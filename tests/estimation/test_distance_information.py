"""Known distances count in standard errors and in what the data identify, as they count in every fit."""

from dataclasses import replace
from functools import cache

import numpy as np
import pytest

from robolaser import Plan, calibrate
from robolaser.data.stated_noise import Noise
from robolaser.estimation.fisher_information import Information
from robolaser.estimation.identifiability import null_directions, standard_errors, unidentifiable
from robolaser.model.forward_model import Model, jacobian
from robolaser.model.noise.covariance import NoiseModel
from robolaser.model.noise.sources import error_sources
from robolaser.robot.by_name import find_robot
from robolaser.simulation import CellOptions, simulate

JOINT_RAD, DISTANCE_M, TRIALS = 2e-4, 2e-5, 24
ROBOT = find_robot("ur5")


def test_a_stated_distance_makes_the_scale_identifiable():
    dataset = simulate(ROBOT, kind="socket", poses=12, points=2, noise=Noise(joint_rad=JOINT_RAD), seed=1).dataset
    model = Model(replace(dataset, noise=replace(dataset.noise, distance_m=DISTANCE_M)))
    x, names, width = model.parameters.nominal, model.parameters.names, model.parameters.width
    sources = error_sources(model, x)
    noise = NoiseModel(sources, {source.name: 1e-5 for source in sources})
    J = jacobian(model, x[None])[0]
    along = x / np.linalg.norm(x)
    blind = J - np.multiply.outer(along, np.tensordot(along, J, axes=1))
    none = np.zeros(len(x), dtype=bool)
    rows = Information.of(blind, noise, weights=noise)
    assert len(null_directions(rows.plain)) == 1
    assert np.isnan(standard_errors(rows, fixed=none)).any()
    both = rows + Information.of_known_distances(model, x)
    assert len(null_directions(both.plain)) == 0
    assert not [one for one in unidentifiable(both, names, width) if len(one.parameters) == len(x)]
    slopes = model.known_distances.jacobian(model.parameters.values(x[None]), names)[0]
    white = np.concatenate([noise.whiten(blind).T, slopes / DISTANCE_M])
    expected = np.sqrt(np.diag(np.linalg.inv(white.T @ white)))
    np.testing.assert_allclose(standard_errors(both, fixed=none), expected, rtol=1e-4)


@cache
def seated():
    """An arm whose tool was put into three sockets, without errors of its readings."""
    options = CellOptions(stated=Noise(joint_rad=JOINT_RAD, point_m=1e-6))
    return simulate(ROBOT, kind="socket", poses=12, points=3, noise=Noise(point_m=1e-6), options=options, seed=0)


@pytest.mark.parametrize("weights", ["plain", "noise"])
def test_standard_errors_match_the_spread_of_fits_with_known_distances(weights):
    rng = np.random.default_rng(3)
    misses, stds, without = [], [], []
    made = seated()
    (_, q), poses = made.dataset.arm, made.dataset.poses
    place = {n: np.array([made.truth[f"socket.{n}.{i}"] for i in "xyz"]) for n in "012"}
    for _ in range(TRIALS):
        pairs = tuple(
            (a, b, float(np.linalg.norm(place[a] - place[b]) + DISTANCE_M * rng.normal()))
            for a, b in ("01", "02", "12")
        )
        read = replace(poses, q=q + JOINT_RAD * rng.normal(size=q.shape))
        noise = replace(made.dataset.noise, distance_m=DISTANCE_M)
        stated = replace(made.dataset, poses=read, distances_m=pairs, noise=noise)
        found = calibrate(stated, Plan(weights=weights)).calibration
        misses.append(found.x - [made.truth[name] for name in found.model.parameters.names])
        stds.append(found.std)
        model, x = found.model, found.x
        rows = NoiseModel(error_sources(model, x), found.noise)
        alone = Information.of(jacobian(model, x[None])[0], rows, weights=None if weights == "plain" else rows)
        without.append(standard_errors(alone, fixed=np.zeros(len(x), dtype=bool)))
    assert 0.9 < np.sqrt(np.mean(np.square(np.array(misses) / np.array(stds)))) < 1.12
    assert np.mean(np.square(stds)) < 0.9 * np.mean(np.square(without))
