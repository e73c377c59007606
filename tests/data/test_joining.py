"""Data sets joined, and digests that tell them apart."""

from dataclasses import fields, replace
from pathlib import Path

import numpy as np
import pytest

from robolaser import load, save
from robolaser.data.dataset import Dataset
from robolaser.data.joining import fingerprint, join_sessions, poses_beyond, with_poses_of
from robolaser.data.sessions import Sessions
from robolaser.data.stated_noise import Noise
from robolaser.errors import DataError
from robolaser.robot.by_name import find_robot
from robolaser.robot.kinematics import Robot
from robolaser.simulation import CellOptions, simulate


def tracked(**options: int) -> Dataset:
    made = simulate("ur5e", kind="point", poses=10, noise=Noise(point_m=2e-5), options=CellOptions(**options), seed=1)
    return made.dataset


def test_a_campaign_with_repeats_and_one_without_are_read_back_as_they_were_joined(tmp_path: Path) -> None:
    whole = join_sessions({"twice": tracked(repeats=2), "once": tracked()}, name="both")
    save(whole, tmp_path)
    back = load(tmp_path)
    assert np.array_equal(back.points.xyz, whole.points.xyz)
    assert np.array_equal(back.points.place, whole.points.place)


def test_sessions_are_not_joined_once_more_since_each_would_lose_its_own_base() -> None:
    once = join_sessions({"monday": tracked(), "friday": tracked()}, name="week")
    with pytest.raises(DataError, match=r"week is several sessions already: monday, friday\. Join"):
        join_sessions({"week": once, "sunday": tracked()}, name="all")


def test_of_two_radii_of_a_ball_the_first_counts() -> None:
    first = simulate("ur5e", kind="profile", poses=10, seed=1).dataset
    other = replace(first, radius_m=dict.fromkeys(first.radius_m, 0.5))
    assert join_sessions({"a": first, "b": other}, name="both").radius_m == first.radius_m


def test_each_of_several_sensors_has_the_largest_noise_that_is_stated_of_it() -> None:
    quiet, loud = (
        simulate("ur5e", kind="stripe+camera", poses=10, noise=Noise(pixel_px=px), seed=1).dataset for px in (0.1, 0.5)
    )
    members = join_sessions({"a": quiet, "b": loud}, name="both").members
    assert [one.data.noise.pixel_px for one in members] == [0.5, 0.5]


def test_an_unplaced_target_with_a_name_is_still_unplaced_when_it_is_read_back(tmp_path: Path) -> None:
    options = CellOptions(placed=False)
    made = simulate("ur5e", kind="stripe+camera", poses=10, noise=Noise(pixel_px=0.1), options=options, seed=1).dataset
    save(replace(made, members=tuple(replace(one, target="board") for one in made.members)), tmp_path)
    assert [(one.target, one.data.placed) for one in load(tmp_path).members] == [("board", False)] * 2


def parts(whole: Dataset) -> list[Dataset]:
    return [
        replace(whole.of_poses(whole.session_of_pose == number), sessions=Sessions((f"session-{number + 1}",)))
        for number in range(2)
    ]


def test_further_poses_may_be_of_another_session() -> None:
    first, second = parts(tracked(sessions=2))
    both = with_poses_of(first, second)
    assert both.sessions.names == ("session-1", "session-2")
    assert np.bincount(both.session_of_pose).tolist() == [10, 10]


def test_further_poses_of_an_unknown_session_are_refused() -> None:
    first, second = parts(tracked(sessions=2))
    nameless = replace(second, sessions=None, poses=replace(second.poses, session=None))
    with pytest.raises(DataError, match="the session of each pose"):
        with_poses_of(first, nameless)


@pytest.mark.parametrize("column", ["payload_kg", "time_s", "temperature_c"])
def test_a_data_set_whose_first_poses_were_corrected_does_not_continue_another(column: str) -> None:
    whole = tracked()
    before = replace(whole, poses=replace(whole.poses, **{column: np.arange(10.0)}))
    after = replace(whole, poses=replace(whole.poses, **{column: np.arange(10.0) + 0.5}))
    old = np.arange(10) < 6
    assert poses_beyond(before.of_poses(old), after) is None
    assert len(poses_beyond(before.of_poses(old), before).poses) == 4


DATASET = simulate(find_robot("ur5"), kind="pose", poses=12).dataset


def heavier(robot: Robot) -> Robot:
    text = robot.urdf.replace('<mass value="', '<mass value="1', 1)
    assert text != robot.urdf
    return Robot.from_urdf(text, flange=robot.flange, joints=robot.joints)


INNER = {
    "a mass in the URDF": {"robot": heavier(DATASET.robot)},
    "quaternions": {"points": replace(DATASET.points, columns={"quaternion": -DATASET.points["quaternion"]})},
    "a time": {"poses": replace(DATASET.poses, time_s=DATASET.poses.time_s + np.arange(12.0))},
    "known distances": {"distances_m": (("a", "b", 0.1),)},
}


@pytest.mark.parametrize("change", INNER.values(), ids=list(INNER))
def test_what_stands_deep_within_counts(change: dict[str, object]) -> None:
    assert fingerprint(replace(DATASET, **change)) != fingerprint(DATASET)


@pytest.mark.parametrize(
    "part", [DATASET, DATASET.poses, DATASET.points, DATASET.noise], ids=lambda x: type(x).__name__
)
def test_every_field_counts_but_for_words(part: object) -> None:
    words = {"name", "source", "licence", "folder", "warnings", "whole"} if isinstance(part, Dataset) else set()
    for one in fields(part):
        other = replace(part)
        object.__setattr__(other, one.name, "another")
        assert (fingerprint(other) == fingerprint(part)) == (one.name in words), one.name


def test_the_same_data_elsewhere_have_the_same_fingerprint() -> None:
    again = simulate(find_robot("ur5"), kind="pose", poses=12).dataset
    assert fingerprint(replace(again, name="copy", folder=Path("elsewhere"))) == fingerprint(DATASET)


def test_what_stands_where_counts() -> None:
    assert fingerprint(("ab", "c")) != fingerprint(("a", "bc"))
    assert fingerprint(np.arange(4.0)) != fingerprint(np.arange(4.0).reshape(2, 2))
    assert fingerprint({"a": 1, "b": 2}) == fingerprint({"b": 2, "a": 1})
