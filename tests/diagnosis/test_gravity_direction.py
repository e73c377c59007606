"""An arm that hangs otherwise than its data set states gives way along another direction, and is told so."""

from dataclasses import replace

import numpy as np
import pytest

import robolaser
from robolaser.data.dataset import Dataset
from robolaser.data.stated_noise import Noise
from robolaser.robot.by_name import find_robot
from robolaser.robot.kinematics import DOWN
from robolaser.simulation import simulate

SOFT = {"joint_compliance:shoulder_lift_joint": 6e-5, "joint_compliance:elbow_joint": 1e-4}
FEW = ["joint_compliance", "link_compliance", "joint_offset"]


def hung(true: tuple[float, float, float], effects: dict[str, float], seed: int) -> Dataset:
    """Moved under one gravity, and stated to stand upright."""
    arm = find_robot("ur5e").under(true)
    made = simulate(arm, kind="point", poses=24, noise=Noise(point_m=3e-5), effects=effects, seed=seed).dataset
    return replace(made, robot=made.arm[0].under(DOWN))


@pytest.mark.parametrize(("true", "seed"), [((0.0, 0.0, 9.81), 2), ((1.7, 0.0, -9.66), 3)], ids=["ceiling", "tilted"])
def test_gravity_that_is_stated_wrongly_is_named_with_what_gives_way(true, seed):
    why = robolaser.diagnose(hung(true, SOFT, seed), effects=FEW, seed=0)
    assert why.verdict == "explained"
    first, *others = why.effects
    assert (first.effect, first.where) == ("gravity_direction", "base")
    found = np.array([first.parameters[axis].value for axis in "xyz"])
    assert np.degrees(np.arccos(found @ true / np.linalg.norm(found) / np.linalg.norm(true))) < 1.0
    assert {f"{one.effect}:{one.where}" for one in others} == set(SOFT)
    assert why.classes[0]["class"] == "base"


def test_gravity_that_is_stated_rightly_is_not_named():
    why = robolaser.diagnose(hung(DOWN, SOFT, 4), effects=FEW, seed=0)
    assert {f"{one.effect}:{one.where}" for one in why.effects} == set(SOFT)


def test_a_cause_that_the_library_lacks_is_not_told_as_gravity():
    made = hung(DOWN, {"link_geometry:elbow_joint": 2e-3, "transmission_error:wrist_1_joint": 2e-3}, 5)
    why = robolaser.diagnose(made, effects=[*FEW, "base_compliance", "tool_sag", "encoder_eccentricity"], seed=0)
    assert "gravity_direction" not in {one.effect for one in why.effects}


def test_a_single_joint_that_yields_upwards_may_be_pulled_by_a_spring_and_does_not_tell_that_the_arm_hangs():
    made = hung((0.0, 0.0, 9.81), {"joint_compliance:shoulder_lift_joint": 6e-5}, 6)
    why = robolaser.diagnose(made, effects=FEW, seed=0)
    assert why.verdict == "unexplained"
    assert why.where[0].site == "shoulder_lift_joint"
    assert "gravity_direction" not in {one.effect for one in why.effects}
