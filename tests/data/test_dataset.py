"""What a data set knows of itself, commanded joints among it."""

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

import robolaser
from robolaser.data.dataset import Dataset, Points, Poses
from robolaser.data.subsampling import evenly, some_of_each, subsampled
from robolaser.data.writing import save
from robolaser.robot.by_name import find_robot
from robolaser.simulation import simulate


@pytest.fixture(params=range(8))
def points(request: pytest.FixtureRequest) -> Points:
    rng = np.random.default_rng(request.param)
    pose = rng.integers(0, 9, rng.integers(1, 90))
    return Points(pose, tuple(str(name) for name in rng.integers(0, 5, len(pose))), xyz=rng.normal(size=(len(pose), 3)))


@pytest.mark.parametrize(("count", "most"), [(0, 5), (1, 5), (5, 5), (17, 5), (1000, 7), (3, 10)])
def test_places_are_each_taken_once_and_reach_from_the_first_to_the_last(count: int, most: int) -> None:
    places = evenly(count, most)
    assert len(places) == len(set(places.tolist())) == min(count, most)
    if count:
        assert (places[0], places[-1]) == (0, count - 1)
        assert np.ptp(np.diff(places)) <= 1 if len(places) > 1 else True


@pytest.mark.parametrize("most", [1, 2, 3, 7, 100])
def test_some_rows_of_each_pose_are_evenly_spread_over_all_of_them(points: Points, most: int) -> None:
    for line, pose in zip(some_of_each(points.pose, most), np.unique(points.pose), strict=True):
        taken, rows = line[line >= 0], np.flatnonzero(points.pose == pose)
        assert len(taken) == min(most, len(rows))
        assert set(taken) <= set(rows)
        assert taken[0] == rows[0]
        assert len(taken) == 1 or taken[-1] == rows[-1]
        assert np.ptp(np.diff(np.searchsorted(rows, taken))) <= 1 if len(taken) > 2 else True


def test_taking_rows_takes_all_of_each(points: Points) -> None:
    rows = np.random.default_rng(1).permutation(len(points))[: len(points) // 2]
    some = points.take(rows)
    assert some.names == tuple(points.names[i] for i in rows)
    assert np.array_equal(some.xyz, points.xyz[rows])
    assert np.array_equal(np.array(points.names)[np.unique(points.number, return_index=True)[1]][points.number],
                          np.array(points.names))  # fmt: skip


def test_subsampling_keeps_every_named_point_and_every_pose_of_others() -> None:
    poses, reflectors = 60, 4
    points = Points(np.repeat(np.arange(poses), reflectors), tuple("abcd") * poses, xyz=np.zeros((240, 3)))
    tracked = Dataset("tracker", Poses(tuple(map(str, range(poses)))), points, kind="point")
    assert np.bincount(subsampled(tracked, 100).points.number).tolist() == [25] * reflectors
    assert np.bincount(subsampled(replace(tracked, kind="stripe"), 180).points.pose).tolist() == [3] * poses
    assert subsampled(tracked, 240) is tracked


def test_what_a_joint_lacks_of_its_command_is_a_coordinate_and_the_command_is_none(tmp_path: Path) -> None:
    made = simulate(find_robot("ur5"), kind="point", poses=5, seed=1).dataset
    told = tuple(repr(float(value) + 1e-3) for value in made.poses.q[:, 2])
    save(replace(made, poses=replace(made.poses, extra={"q_command_elbow_joint": told})), tmp_path / "told")
    loaded = robolaser.load(tmp_path / "told")
    assert loaded.warnings == ()
    poses = loaded.poses
    assert poses.coordinates["q_command_elbow_joint less q_elbow_joint"] == pytest.approx(1e-3)
    assert "q_command_elbow_joint" not in poses.coordinates
    assert poses.take(np.array([0, 2])).following["elbow_joint"] == pytest.approx(1e-3)
