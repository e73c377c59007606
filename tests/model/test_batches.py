"""A data set in batches is the data set: the same residuals, optimum, held-out errors and standard errors."""

from dataclasses import replace

import numpy as np
import pytest
from asked import simulate_as_asked

from robolaser.calibration.calibrate import calibrate
from robolaser.calibration.plan import Plan
from robolaser.data.board import Board
from robolaser.data.several_sensors import with_points_of
from robolaser.data.stated_noise import Noise
from robolaser.estimation.folds import TOLERANCE, assign_folds, held_out
from robolaser.estimation.noise_estimate import noise_of
from robolaser.estimation.problem import Problem
from robolaser.estimation.solver import solve
from robolaser.model.effects import candidate_effects
from robolaser.model.forward_model import Model, batches_of
from robolaser.model.noise.covariance import NoiseModel
from robolaser.model.noise.sources import error_sources
from robolaser.robot.by_name import find_robot
from robolaser.simulation import simulate

NOISE = Noise(pixel_px=0.1, target_m=3e-5, joint_rad=1e-5, point_m=2e-5, angle_rad=1e-4)
SMALL = 50

CELLS = {
    "stripe": {"poses": 15, "points": 10},
    "stripe, unplaced, repeated": {"poses": 12, "points": 5, "placed": False, "repeats": 2},
    "tracker": {"kind": "point", "poses": 40},
    "bodies": {"kind": "pose", "poses": 60},
    "profiles": {"kind": "profile", "poses": 12},
    "camera": {"kind": "camera", "poses": 15, "points": 10},
    "sockets": {"kind": "socket", "poses": 90},
}


@pytest.fixture(params=CELLS, scope="module")
def dataset(request):
    return simulate_as_asked(find_robot("scorbot_er7"), noise=NOISE, seed=3, **CELLS[request.param]).dataset


@pytest.fixture
def small_batches(monkeypatch):
    monkeypatch.setattr("robolaser.model.forward_model.ROWS", SMALL)


def near(model, count):
    parameters = model.parameters
    return parameters.nominal + 1e-3 * parameters.width * np.random.default_rng(0).normal(size=(count, len(parameters)))


def test_batches_are_whole_poses_and_hold_each_row_once(dataset, small_batches):
    batches = batches_of(Model(dataset))
    assert len(batches) > 1
    assert sorted(np.concatenate([rows for rows, _ in batches])) == list(range(len(dataset.points)))
    poses = [set(dataset.points.pose[rows]) for rows, _ in batches]
    assert sum(map(len, poses)) == len(set.union(*poses))


def test_a_row_in_a_batch_is_as_far_off_as_among_all(dataset, small_batches):
    model = Model(dataset)
    x = near(model, 3)
    E = model.residuals(x)
    for rows, batch in batches_of(model):
        np.testing.assert_allclose(batch.residuals(x), E[:, rows], atol=1e-12)


def test_whitened_rows_are_the_same_in_batches(dataset, small_batches):
    model = Model(dataset)
    x = near(model, 2)
    start = model.parameters.nominal
    problem = Problem.of(model, NoiseModel(error_sources(model, start), noise_of(model, start).sigmas))
    whole = problem.residuals(x).reshape(2, problem.rows, -1)
    for rows, batch in problem.batches:
        np.testing.assert_allclose(batch.residuals(x).reshape(2, len(rows), -1), whole[:, rows], rtol=1e-6, atol=1e-6)


def test_effects_that_look_around_keep_all_rows_together(small_batches):
    dataset = simulate(find_robot("scorbot_er7"), noise=NOISE, poses=20, seed=3).dataset
    assert len(batches_of(Model(dataset, candidate_effects(("hand_eye_drift",), dataset)))) == 1
    assert len(batches_of(Model(dataset, candidate_effects(("laser_roll",), dataset)))) > 1


NOISY = ("stripe, unplaced, repeated", "tracker", "camera")
"""Whitened rows of the others are compared above."""


@pytest.mark.parametrize(
    ("dataset", "weights"),
    [*((kind, "plain") for kind in CELLS), *((kind, "noise") for kind in NOISY)],
    indirect=["dataset"],
)
def test_a_calibration_in_batches_is_that_of_the_whole(dataset, monkeypatch, weights):
    plan = Plan(algorithm="gauss-newton", weights=weights)
    whole = calibrate(dataset, plan)
    monkeypatch.setattr("robolaser.model.forward_model.ROWS", SMALL)
    monkeypatch.setattr("robolaser.estimation.plain_fit.FEWER", 50)
    parts = calibrate(dataset, plan)
    width = whole.model.parameters.width
    np.testing.assert_allclose(parts.x / width, whole.x / width, atol=1e-5)
    np.testing.assert_allclose(parts.std, whole.std, rtol=1e-3)
    assert parts.held_out_rms_m == pytest.approx(whole.held_out_rms_m, rel=1e-3)
    assert [one.parameters for one in parts.unidentifiable] == [one.parameters for one in whole.unidentifiable]


def test_held_out_poses_are_predicted_by_fits_of_all_others(dataset, small_batches):
    model = Model(dataset)
    problem = Problem.of(model)
    x = solve(problem, model.parameters.nominal[None]).x[0]
    folds = assign_folds(model, seed=1)
    errors = held_out(problem, x, folds).errors
    for fold in range(min(2, folds.count)):
        out = folds.of_row == fold
        whole = model.residuals(solve(problem, x[None], tol=TOLERANCE / 10, kept=~out[None]).x)[0]
        expected = (model.blocks.relocated(whole) if folds.whole else whole)[out]
        assert np.linalg.norm(errors[out] - expected) < 0.05 * np.linalg.norm(expected)


def test_poses_of_one_row_err_as_a_whole_too_although_all_of_a_batch_have_one(monkeypatch):
    made = simulate("ur5", kind="point", poses=80, noise=Noise(point_m=1e-5), seed=4).dataset
    off = 2e-4 * np.random.default_rng(0).standard_normal((80, 3))
    points = replace(made.points, xyz=made.points.xyz + off[made.points.pose])
    points = points.take((points.pose < 20) | (points.number == 0))
    dataset = replace(made, points=points, noise=Noise())
    whole = calibrate(dataset)
    monkeypatch.setattr("robolaser.model.forward_model.ROWS", 30)
    np.testing.assert_allclose(calibrate(dataset).std, whole.std, rtol=1e-6)


@pytest.mark.parametrize(("weights", "sessions"), [("plain", 2), ("noise", 1)])
def test_a_batch_may_lack_the_sensor_of_the_longest_rows(weights, sessions, monkeypatch):
    made = simulate_as_asked("ur5e", kind="stripe+camera", poses=16 // sessions, noise=NOISE, sessions=sessions, seed=1)
    stripe, camera = made.dataset.sensors
    early = stripe.data.points.take(stripe.data.points.pose < 8)
    board = Board(7, 6, 0.02)
    members = [replace(one, data=replace(one.data, board=board)) for one in (camera, stripe)]
    dataset = with_points_of(replace(made.dataset, members=tuple(members), board=board), [camera.data.points, early])
    plan = Plan(algorithm="gauss-newton", weights=weights)
    whole = calibrate(dataset, plan)
    monkeypatch.setattr("robolaser.model.forward_model.ROWS", 2 * SMALL)
    parts = calibrate(dataset, plan)
    assert parts.rms_m == pytest.approx(whole.rms_m, rel=1e-6)
    assert parts.held_out_rms_m == pytest.approx(whole.held_out_rms_m, rel=1e-3)
