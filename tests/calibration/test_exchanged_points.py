"""Reflectors of some poses that were named in another order, told by their distances from each other."""

from dataclasses import replace

import numpy as np
import pytest

import robolaser
from robolaser.calibration.other_readings import exchanged_points, with_names
from robolaser.data.dataset import Dataset
from robolaser.data.stated_noise import Noise
from robolaser.simulation import simulate


def measured() -> Dataset:
    return simulate("ur5", kind="point", poses=40, noise=Noise(point_m=3e-5), seed=2).dataset


def exchanged(data: Dataset, poses: list[int]) -> Dataset:
    a, b, _ = dict.fromkeys(data.points.names)
    return with_names(data, {pose: {a: b, b: a} for pose in poses})


def test_where_names_are_right_nothing_is_said() -> None:
    assert exchanged_points(measured()) == {}


@pytest.mark.parametrize("poses", [[3], [0, 7, 8, 30], list(range(0, 30, 2))])
def test_exchanged_names_are_put_right(poses: list[int]) -> None:
    data = measured()
    wrong = exchanged(data, poses)
    found = exchanged_points(wrong)
    assert sorted(found) == poses
    assert with_names(wrong, found).points.names == data.points.names


def test_three_names_may_have_gone_round() -> None:
    data = measured()
    a, b, c = dict.fromkeys(data.points.names)
    wrong = with_names(data, {5: {a: b, b: c, c: a}})
    assert with_names(wrong, exchanged_points(wrong)).points.names == data.points.names


def test_a_body_whose_distances_are_alike_says_nothing() -> None:
    data = measured()
    assert data.points.xyz is not None
    number = np.array([sorted(set(data.points.names)).index(name) for name in data.points.names])
    triangle = 0.1 * np.array([[1.0, 0.0, 0.0], [-0.5, np.sqrt(0.75), 0.0], [-0.5, -np.sqrt(0.75), 0.0]])
    alike = replace(data, points=replace(data.points, xyz=triangle[number]))
    assert exchanged_points(exchanged(alike, [1, 2])) == {}


def test_the_diagnosis_says_which_points_of_which_poses() -> None:
    found = robolaser.diagnose(exchanged(measured(), [3, 9, 12, 20, 31]), seed=0)
    assert "of poses 3, 9, 12, 20 and others seem to be exchanged: with that corrected" in found.sentence
    assert found.effects == []
