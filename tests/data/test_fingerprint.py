"""A digest tells data sets apart that differ in any number, and no others."""

from dataclasses import fields, replace
from pathlib import Path

import numpy as np
import pytest

from robolaser.data.dataset import Dataset
from robolaser.data.fingerprint import fingerprint
from robolaser.data.stated_noise import Noise
from robolaser.robot.by_name import find_robot
from robolaser.robot.kinematics import Robot
from robolaser.simulation import simulate

DATASET = simulate(find_robot("ur5"), kind="pose", poses=12).dataset
ONES = np.ones((12, 2))


def heavier(robot: Robot) -> Robot:
    text = robot.urdf.replace('<mass value="', '<mass value="1', 1)
    assert text != robot.urdf
    return Robot.from_urdf(text, flange=robot.flange, joints=robot.joints)


CHANGES = {
    "a mass in the URDF": {"robot": heavier(DATASET.robot)},
    "the bracket": {"bracket_quat": (0.0, 0.0, 1.0, 0.0)},
    "the stripe's axis": {"stripe_axis": "v"},
    "quaternions": {"points": replace(DATASET.points, columns={"quaternion": -DATASET.points["quaternion"]})},
    "a further column": {"points": replace(DATASET.points, columns={**DATASET.points.columns, "profile": ONES})},
    "the radius of a ball": {"radius_m": {"ball": 0.0127}},
    "velocities": {"poses": replace(DATASET.poses, qd=DATASET.poses.q + 0.1)},
    "times": {"poses": replace(DATASET.poses, time_s=DATASET.poses.time_s + np.arange(12.0))},
    "the noise": {"noise": Noise(joint_rad=1e-4)},
    "known distances": {"distances_m": (("a", "b", 0.1),)},
    "what is known of the path": {"path_known": False},
}


@pytest.mark.parametrize("change", CHANGES.values(), ids=list(CHANGES))
def test_other_data_have_another_fingerprint(change: dict[str, object]) -> None:
    assert fingerprint(replace(DATASET, **change)) != fingerprint(DATASET)


@pytest.mark.parametrize(
    "part", [DATASET, DATASET.poses, DATASET.points, DATASET.noise], ids=lambda x: type(x).__name__
)
def test_every_field_counts_but_for_words(part: object) -> None:
    words = {"name", "source", "licence", "folder", "warnings"} if isinstance(part, Dataset) else set()
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
