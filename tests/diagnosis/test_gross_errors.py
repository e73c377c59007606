"""Points that are far off are gross errors for certain only where the others of their pose are not."""

from dataclasses import replace

import numpy as np
import pytest
from several import two_trackers

from robolaser.calibration.other_readings import with_rows_moved
from robolaser.data.dataset import Dataset
from robolaser.data.stated_noise import Noise
from robolaser.diagnosis import examine
from robolaser.diagnosis.gross_errors import gross_sentence, outlying_poses, probability
from robolaser.diagnosis.result_json import diagnosis_json
from robolaser.diagnosis.thresholds import CERTAIN
from robolaser.report.diagnosis.advice import to_do
from robolaser.simulation import simulate


@pytest.fixture(scope="module")
def sound() -> Dataset:
    return simulate("ur5", kind="point", poses=40, noise=Noise(point_m=3e-5), seed=1).dataset


def off(dataset: Dataset, rows: np.ndarray) -> Dataset:
    xyz = np.array(dataset.points.xyz)
    xyz[rows] += 2e-3
    return replace(dataset, points=replace(dataset.points, xyz=xyz))


def test_single_points_are_gross_errors_for_certain(sound: Dataset) -> None:
    rows = np.flatnonzero(sound.points.pose < 3)[::3]
    found = examine(off(sound, rows), seed=0)
    (told,) = [one for one in diagnosis_json(found)["effects"] if one["effect"] == "outliers"]
    assert told["probability"] == 1.0
    assert "3 rows of points.csv are gross errors" in found.sentence


def test_a_pose_that_is_off_as_a_whole_is_likely_a_gross_error_and_is_named(sound: Dataset) -> None:
    rows = np.flatnonzero(sound.points.pose == 7)
    found = examine(off(sound, rows), seed=0)
    (told,) = [one for one in diagnosis_json(found)["effects"] if one["effect"] == "outliers"]
    assert 0.5 < told["probability"] < CERTAIN
    assert f"All points of pose {sound.poses.names[7]} are off together" in found.sentence
    assert any(f"measurements of pose {sound.poses.names[7]};" in one for one in to_do(found))


def test_few_scattered_points_and_whole_poses_are_gross_errors(sound: Dataset) -> None:
    scattered = np.random.default_rng(4).random(len(sound.points)) < 0.05
    rows = np.flatnonzero(scattered | np.isin(sound.points.pose, [7, 30]))
    found = examine(off(sound, rows), seed=0)
    assert found.verdict == "no_gap"
    assert found.outliers.tolist() == rows.tolist()


def test_a_reflector_that_slips_half_way_is_no_gross_error(sound: Dataset) -> None:
    rows = np.flatnonzero((sound.points.number == 1) & (sound.points.pose >= 20))
    found = examine(off(sound, rows), seed=0)
    assert found.verdict != "no_gap"
    assert not len(found.outliers)


def test_a_tracker_whose_rows_are_one_pose_off_is_told_beside_a_sound_one() -> None:
    both = two_trackers(30)
    found = examine(with_rows_moved(both, 1, of=both.sensors[1].rows), seed=0)
    assert found.wrong_input is not None
    assert found.wrong_input.name == "mispaired"
    assert "All rows of right.csv seem to belong to the pose before theirs" in found.sentence
    assert not len(found.outliers)


def test_nothing_is_said_without_gross_errors(sound: Dataset) -> None:
    none = np.zeros(0, dtype=np.int64)
    assert gross_sentence(sound, none) == ""
    assert outlying_poses(sound, none) == ()
    assert probability(sound, none, "no_gap") == 1.0


def test_beside_what_is_unexplained_no_gross_error_is_certain(sound: Dataset) -> None:
    first = np.zeros(1, dtype=np.int64)
    assert probability(sound, first, "explained") == 1.0
    assert 0.5 < probability(sound, first, "unexplained") < CERTAIN
