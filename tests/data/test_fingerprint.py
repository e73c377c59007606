"""A digest tells data sets apart that differ in any number, and no others."""

from dataclasses import fields, replace
from pathlib import Path

import numpy as np
import pytest

from robolaser.data.dataset import Dataset
from robolaser.data.joining import fingerprint
from robolaser.robot.by_name import find_robot
from robolaser.robot.kinematics import Robot
from robolaser.simulation import simulate

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
