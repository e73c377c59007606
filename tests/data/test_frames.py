"""Data sets of columns in memory: as those of files."""

from dataclasses import replace

import numpy as np
import pandas as pd
import pytest

import robolaser
from robolaser.data.dataset import Dataset
from robolaser.data.stated_noise import Noise
from robolaser.errors import DataError, UsageError
from robolaser.simulation import simulate


def frames(dataset: Dataset) -> tuple[dict[str, list[float]], dict[str, list[object]]]:
    robot, q = dataset.arm
    xyz = np.array(dataset.points.xyz)
    poses = {f"q_{joint}": q[:, i].tolist() for i, joint in enumerate(robot.joints)}
    points: dict[str, list[object]] = {"pose": dataset.points.pose.tolist(), "point": list(dataset.points.names)}
    return poses, points | {f"{axis}_m": xyz[:, i].tolist() for i, axis in enumerate("xyz")}


@pytest.fixture(scope="module")
def measured() -> Dataset:
    return simulate("ur5", kind="point", poses=30, noise=Noise(point_m=3e-5), seed=2).dataset


@pytest.mark.parametrize("made", [dict, pd.DataFrame])
def test_columns_give_the_data_set_that_files_give(made, measured: Dataset) -> None:
    poses, points = frames(measured)
    dataset = Dataset.from_frames(made(poses), made(points), robot="ur5", noise={"point_m": 3e-5})
    np.testing.assert_array_equal(dataset.poses.q, measured.poses.q)
    np.testing.assert_array_equal(dataset.points.xyz, measured.points.xyz)
    assert dataset.noise.point_m == 3e-5
    hung = robolaser.find_robot("ur5", gravity=(0.0, 0.0, 9.81))
    assert Dataset.from_frames(made(poses), made(points), robot=hung).robot.gravity == hung.gravity
    found, known = (robolaser.calibrate(each, weights="noise", seed=0) for each in (dataset, measured))
    np.testing.assert_allclose(found.x, known.x, rtol=1e-9)


def test_a_missing_column_is_named(measured: Dataset) -> None:
    poses, points = frames(measured)
    del points["y_m"]
    with pytest.raises(DataError, match="y_m"):
        Dataset.from_frames(poses, points, robot="ur5")


def test_columns_of_different_lengths_are_refused(measured: Dataset) -> None:
    poses, points = frames(measured)
    with pytest.raises(DataError, match="different lengths"):
        Dataset.from_frames(poses, points | {"x_m": [1.0]}, robot="ur5")


def test_settings_may_be_numbers_and_arrays_of_numpy(measured: Dataset) -> None:
    poses, points = frames(measured)
    tables = {
        "noise": {"point_m": np.std([0.0, 2e-5])},
        "target": {"placed": np.bool_(False), "distances_m": [("0", "1", np.linalg.norm([0.3, 0.4]))]},
        "parameters": {"base.x": {"nominal": np.float64(1.5), "lower": None, "fixed": np.bool_(True)}},
    }
    dataset = Dataset.from_frames(poses, points, robot="ur5", **tables)
    assert (dataset.noise.point_m, dataset.placed, dataset.distances_m) == (1e-5, False, (("0", "1", 0.5),))
    assert dataset.parameters["base.x"].nominal == 1.5


def test_a_flange_without_a_file_to_find_it_in_is_refused(measured: Dataset) -> None:
    with pytest.raises(UsageError, match="flange 'tool0' is of a robot by name or file"):
        Dataset.from_frames(*frames(measured), robot=measured.robot, flange="tool0")


def test_columns_may_be_read_once_only(measured: Dataset) -> None:
    poses, points = frames(measured)
    once = Dataset.from_frames({name: iter(values) for name, values in poses.items()}, points, robot="ur5")
    np.testing.assert_array_equal(once.poses.q, measured.poses.q)


def test_a_data_set_with_numbers_of_numpy_is_saved(measured: Dataset, tmp_path) -> None:
    noisy = replace(measured, noise=Noise(point_m=np.float64(3e-5)), image_px=tuple(np.array([640, 480])))
    robolaser.save(noisy, tmp_path)
    assert robolaser.load(tmp_path).noise == noisy.noise
