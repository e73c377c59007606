"""Commands beside readings: what a joint lacks of its command may explain a gap."""

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

import robolaser
from robolaser.data.writing import save
from robolaser.robot.by_name import find_robot
from robolaser.simulation import simulate


def test_what_a_joint_lacks_of_its_command_is_a_coordinate_and_the_command_is_none(tmp_path: Path) -> None:
    made = simulate(find_robot("ur5"), kind="point", poses=5, seed=1).dataset
    assert made.poses.q is not None
    told = tuple(repr(float(value) + 1e-3) for value in made.poses.q[:, 2])
    save(replace(made, poses=replace(made.poses, extra={"q_command_elbow_joint": told})), tmp_path / "told")
    loaded = robolaser.load(tmp_path / "told")
    assert loaded.warnings == ()
    poses = loaded.poses
    assert poses.coordinates["q_command_elbow_joint less q_elbow_joint"] == pytest.approx(1e-3)
    assert "q_command_elbow_joint" not in poses.coordinates
    assert poses.take(np.array([0, 2])).following["elbow_joint"] == pytest.approx(1e-3)
