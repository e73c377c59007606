"""What is held out is predicted by a fit of all the rest, and by nothing else."""

from dataclasses import replace

import numpy as np
import pytest

from robolaser.data.dataset import Dataset
from robolaser.data.stated_noise import Noise
from robolaser.estimation.folds import FOLDS, assign_folds, held_out
from robolaser.estimation.problem import Problem
from robolaser.estimation.solver import solve
from robolaser.model.forward_model import Model
from robolaser.robot.by_name import find_robot
from robolaser.simulation import simulate


@pytest.mark.parametrize("kind", ["stripe", "point", "pose", "profile", "socket"])
def test_rows_are_predicted_as_a_fit_without_their_poses_predicts_them(kind):
    noise = Noise(pixel_px=0.1, target_m=3e-5) if kind == "stripe" else Noise(point_m=3e-5, joint_rad=1e-5)
    model = Model(simulate(find_robot("ur5"), kind=kind, poses=24, noise=noise, seed=3).dataset)
    problem = Problem.of(model)
    x = solve(problem, model.parameters.nominal[None]).x[0]
    folds = assign_folds(model, 1)
    errors = held_out(problem, x, folds).errors
    for fold in range(min(4, folds.count)):
        out = folds.of_row == fold
        whole = model.residuals(solve(problem, x[None], kept=~out[None], tol=1e-12).x)[0]
        there = (model.blocks.relocated(whole) if folds.whole else whole)[out]
        assert np.sqrt(((errors[out] - there) ** 2).mean() / (there**2).mean()) < 0.02


def cell(**more: object) -> Dataset:
    return simulate(find_robot("scorbot_er7"), noise=Noise(pixel_px=0.1), seed=3, **more).dataset


def test_poses_are_held_out_whole_and_once():
    dataset = cell(poses=25, points=4)
    folds = assign_folds(Model(dataset), seed=3)
    assert folds.count == FOLDS
    for pose in np.unique(dataset.points.pose):
        assert len(set(folds.of_row[dataset.points.pose == pose])) == 1
    assert np.ptp(np.bincount(folds.of_row)) <= 4


def test_sockets_are_held_out_whole_with_those_at_known_distances():
    made = cell(kind="socket", poses=60, points=5)
    names = list(dict.fromkeys(made.points.names))
    dataset = replace(made, distances_m=((names[0], names[1], 0.05),))
    folds = assign_folds(Model(dataset), seed=3)
    of_socket = {name: set(folds.of_row[np.array(dataset.points.names) == name]) for name in names}
    assert all(len(fold) == 1 for fold in of_socket.values())
    assert of_socket[names[0]] == of_socket[names[1]]
    assert folds.count == len(names) - 1


def chained(sockets: int, poses: int = 60) -> Dataset:
    """Sockets on plates of two, 50 mm apart, and the distance of each plate from the next one."""
    made = cell(kind="socket", poses=poses, points=sockets)
    names = sorted(set(made.points.names))
    lengths = (0.05 if i % 2 == 0 else 0.4 for i in range(sockets))
    return replace(made, distances_m=tuple(zip(names, names[1:], lengths, strict=False)))


@pytest.mark.parametrize(("sockets", "count"), [(6, 3), (5, 3), (4, 4), (2, 2)])
def test_sockets_that_distances_all_connect_are_held_out_whole_alone_or_with_their_nearest(sockets, count):
    dataset = chained(sockets)
    folds = assign_folds(Model(dataset), seed=3)
    assert folds.whole
    assert folds.count == count
    of_socket = {one: set(folds.of_row[np.array(dataset.points.names) == one]) for one in dataset.points.names}
    assert all(len(fold) == 1 for fold in of_socket.values())
    assert sockets < 5 or all(
        of_socket[one] == of_socket[other] for one, other, length in dataset.distances_m if length == 0.05
    )
    (warning,) = folds.warnings
    assert f"{count - 1} known distances lead from sockets that are held out to others" in warning


def test_known_distances_to_a_socket_that_is_held_out_do_not_change_how_its_poses_are_predicted():
    dataset = chained(6)
    names = np.array(dataset.points.names)
    socket_m = {}
    model = Model(replace(dataset, distances_m=()))
    x = solve(Problem.of(model), model.parameters.nominal[None]).x[0]
    at = dict(zip(model.parameters.names, x, strict=True))
    for one in names:
        socket_m[one] = np.array([at[f"socket.{one}.{axis}"] for axis in "xyz"])
    true = tuple((a, b, float(np.linalg.norm(socket_m[a] - socket_m[b]))) for a, b, _ in dataset.distances_m)
    model = Model(replace(dataset, distances_m=true))
    problem = Problem.of(model)
    folds = assign_folds(model, seed=3)
    found = held_out(problem, x, folds).errors
    first = replace(dataset, distances_m=tuple(pair for pair in true if dataset.points.names[0] not in pair[:2]))
    out = folds.of_row == folds.of_row[0]
    without = Problem.of(Model(first))
    alone = model.blocks.relocated(without.plain(solve(without, x[None], kept=~out[None], tol=1e-12).x)[0])
    np.testing.assert_allclose(found[out], alone[out], atol=2e-6)


def test_poses_in_a_single_socket_are_held_out_one_by_one_and_it_is_said():
    folds = assign_folds(Model(cell(kind="socket", poses=30, points=1)), seed=3)
    assert not folds.whole
    assert folds.warnings[0].startswith("There is only one socket")


def test_a_socket_that_is_held_out_is_located_from_its_own_poses():
    made = cell(kind="socket", poses=60, points=5)
    model = Model(replace(made, distances_m=()))
    problem = Problem.of(model)
    x = solve(problem, model.parameters.nominal[None]).x[0]
    errors = held_out(problem, x, assign_folds(model, seed=3)).errors
    for name in set(made.points.names):
        np.testing.assert_allclose(errors[np.array(made.points.names) == name].mean(axis=0), 0.0, atol=1e-12)


@pytest.mark.parametrize("apart", [1e-6, 4e-5])
def test_copies_of_a_pose_never_land_on_both_sides(apart):
    dataset = cell(poses=12, points=4)
    q = dataset.poses.q
    copies = q[:6] + apart * np.random.default_rng(1).uniform(-1.0, 1.0, q[:6].shape)
    twins = replace(dataset, poses=replace(dataset.poses, q=np.concatenate([q[:6], copies])))
    folds = assign_folds(Model(twins), seed=1)
    of_pose = [set(folds.of_row[twins.points.pose == pose]) for pose in range(12)]
    assert of_pose[:6] == of_pose[6:]
    (warning,) = folds.warnings
    assert warning.startswith("6 poses repeat")
    assert assign_folds(Model(dataset), seed=1).warnings == ()


def test_copies_of_two_poses_are_too_few_to_hold_any_out():
    dataset = cell(poses=8, points=4)
    alike = replace(dataset, poses=replace(dataset.poses, q=np.repeat(dataset.poses.q[:2], 4, axis=0)))
    assert assign_folds(Model(alike), seed=1) is None
