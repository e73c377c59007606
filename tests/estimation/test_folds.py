"""What is held out is predicted by a fit of all the rest, and by nothing else."""

from dataclasses import replace

import numpy as np
import pytest

from robolaser.data.dataset import Dataset, Noise
from robolaser.estimation.folds import FOLDS, assign_folds, held_out
from robolaser.estimation.problem import Problem
from robolaser.estimation.solver import solve
from robolaser.model.forward_model import Model
from robolaser.robot.by_name import find_robot
from robolaser.simulation import simulate


@pytest.mark.parametrize("kind", ["stripe", "point", "pose", "profile", "socket"])
def test_rows_are_predicted_as_a_fit_without_their_poses_predicts_them(kind: str) -> None:
    noise = Noise(pixel_px=0.1, target_m=3e-5) if kind == "stripe" else Noise(point_m=3e-5, joint_rad=1e-5)
    model = Model(simulate(find_robot("ur5"), kind=kind, poses=24, noise=noise, seed=3).dataset)
    problem = Problem.of(model)
    x = solve(problem, model.parameters.nominal[None]).x[0]
    folds = assign_folds(model, 1)
    assert folds is not None
    errors = held_out(problem, x, folds).errors
    for fold in range(4):
        out = folds.of_row == fold
        refitted = solve(problem, x[None], kept=~out[None], tol=1e-12).x
        there = model.residuals(refitted)[0, out]
        apart = np.sqrt(((errors[out] - there) ** 2).mean() / (there**2).mean())
        assert apart < 0.02


def cell(**more: object) -> Dataset:
    return simulate(find_robot("scorbot_er7"), noise=Noise(pixel_px=0.1), seed=3, **more).dataset  # type: ignore[arg-type]


def test_poses_are_held_out_whole_and_once() -> None:
    dataset = cell(poses=25, points=4)
    folds = assign_folds(Model(dataset), seed=3)
    assert folds is not None
    assert folds.count == FOLDS
    for pose in np.unique(dataset.points.pose):
        assert len(set(folds.of_row[dataset.points.pose == pose])) == 1
    assert np.ptp(np.bincount(folds.of_row)) <= 4


def test_sockets_are_held_out_whole_with_those_at_known_distances() -> None:
    made = cell(kind="socket", poses=60, points=5)
    names = list(dict.fromkeys(made.points.names))
    dataset = replace(made, distances_m=((names[0], names[1], 0.05),))
    folds = assign_folds(Model(dataset), seed=3)
    assert folds is not None
    of_socket = {name: set(folds.of_row[np.array(dataset.points.names) == name]) for name in names}
    assert all(len(fold) == 1 for fold in of_socket.values())
    assert of_socket[names[0]] == of_socket[names[1]]
    assert folds.count == len(names) - 1


def test_a_socket_that_is_held_out_is_located_from_its_own_poses() -> None:
    made = cell(kind="socket", poses=60, points=5)
    model = Model(replace(made, distances_m=()))
    problem = Problem.of(model)
    x = solve(problem, model.parameters.nominal[None]).x[0]
    folds = assign_folds(model, seed=3)
    assert folds is not None
    errors = held_out(problem, x, folds).errors
    for name in set(made.points.names):
        np.testing.assert_allclose(errors[np.array(made.points.names) == name].mean(axis=0), 0.0, atol=1e-12)


def test_copies_of_a_pose_never_land_on_both_sides() -> None:
    dataset = cell(poses=12, points=4)
    q = dataset.poses.q
    assert q is not None
    twins = replace(dataset, poses=replace(dataset.poses, q=np.concatenate([q[:6], q[:6] + 1e-6])))
    folds = assign_folds(Model(twins), seed=1)
    assert folds is not None
    of_pose = [set(folds.of_row[twins.points.pose == pose]) for pose in range(12)]
    assert of_pose[:6] == of_pose[6:]
    assert folds.copies == 6
    (warning,) = folds.warnings
    assert warning.startswith("6 poses repeat")
    originals = assign_folds(Model(dataset), seed=1)
    assert originals is not None
    assert originals.warnings == ()


def test_copies_of_two_poses_are_too_few_to_hold_any_out() -> None:
    dataset = cell(poses=8, points=4)
    q = dataset.poses.q
    assert q is not None
    alike = replace(dataset, poses=replace(dataset.poses, q=np.repeat(q[:2], 4, axis=0)))
    assert assign_folds(Model(alike), seed=1) is None
