"""Points that are far off are gross errors for certain only where the others of their pose are not."""

from dataclasses import replace

import numpy as np
import pytest

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


def test_nothing_is_said_without_gross_errors(sound: Dataset) -> None:
    none = np.zeros(0, dtype=np.int64)
    assert gross_sentence(sound, none) == ""
    assert outlying_poses(sound, none) == ()
    assert probability(sound, none, "no_gap") == 1.0


def test_beside_what_is_unexplained_no_gross_error_is_certain(sound: Dataset) -> None:
    first = np.zeros(1, dtype=np.int64)
    assert probability(sound, first, "explained") == 1.0
    assert 0.5 < probability(sound, first, "unexplained") < CERTAIN
