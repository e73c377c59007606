"""What only imitates a cause outside the library explains nothing."""

from dataclasses import replace

import numpy as np
import pytest

import robolaser
from robolaser.data.dataset import Dataset
from robolaser.data.stated_noise import Noise
from robolaser.robot.by_name import find_robot
from robolaser.simulation import simulate

OF_JOINTS = ["joint_offset", "encoder_scale", "encoder_eccentricity", "backlash", "settling", "joint_coupling"]


def of_one_joint(kind: str) -> Dataset:
    """Three reflectors, and a joint that is off by chance, or by where it came from, in no form of the library."""
    robot, rng = find_robot("ur5"), np.random.default_rng(4)
    made = simulate(robot, kind="point", poses=45, points=3, noise=Noise(point_m=3e-5), seed=4).dataset
    q = made.poses.q.copy()
    if kind == "scatter":
        q[:, 4] -= 8e-4 * rng.normal(size=len(q))
    else:
        q[1:, 2] -= 5e-4 * np.tanh(np.diff(q[:, 2]) / 0.2)
    return replace(made, poses=replace(made.poses, q=q))


@pytest.mark.parametrize("kind", ["scatter", "last move"])
def test_a_gap_is_explained_only_where_a_cause_is_listed(kind: str) -> None:
    why = robolaser.diagnose(of_one_joint(kind), effects=OF_JOINTS, seed=0)
    named = [one for one in why.effects if one.effect != "outliers"]
    assert why.verdict != "explained" or named
    assert "part of the gap is explained" not in why.sentence or named or why.classes[0]["probability"] > 0.5
