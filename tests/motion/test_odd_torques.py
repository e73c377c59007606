"""Torques of arms that MuJoCo moves, read at their limits, with a wrong sign or under another gravity than stated."""

from dataclasses import replace
from functools import cache

import numpy as np
import pytest
from moved_arms import JOINTS, World, record

from robolaser.motion.diagnosis import MotionDiagnosis, diagnose_motion
from robolaser.motion.log import MotionLog
from robolaser.motion.result_json import CERTAIN, motion_json, sentence

ELBOW, LIFT = JOINTS.index("elbow"), JOINTS.index("lift")
FRICTION = ("coulomb_friction", "elbow")


@cache
def dry() -> MotionLog:
    """An arm with friction in its elbow, commands left out."""
    log = record(World(dry={"elbow": 4.0}), series=4, seconds=5.0, seed=5)
    return replace(log, command=np.full_like(log.q, np.nan))


def with_lift(change: np.ndarray) -> MotionDiagnosis:
    tau = dry().tau.copy()
    tau[:, LIFT] = change
    return diagnose_motion(replace(dry(), tau=tau), seed=0)


def certain(found: MotionDiagnosis) -> set[tuple[str, str]]:
    return {(one["effect"], one["where"]) for one in motion_json(found)["effects"] if one["probability"] >= CERTAIN}


@pytest.mark.parametrize("share", [0.3, 0.6, 0.9])
def test_torques_that_stay_at_a_limit_are_named_and_no_scale_of_theirs(share: float) -> None:
    read = dry().tau[:, LIFT]
    most = share * read.min()
    found = with_lift(np.maximum(read, most))
    assert found.verdict == "unexplained"
    assert found.places[0].site == "lift"
    assert certain(found) <= {FRICTION}
    assert f"Torques of lift are cut off at {most:.3g} Nm" in sentence(found)


def test_torques_that_bend_towards_a_limit_are_of_no_certain_cause() -> None:
    read = dry().tau[:, LIFT]
    most = 0.5 * np.abs(read).max()
    found = with_lift(most * np.tanh(read / most))
    assert found.verdict == "unexplained"
    assert found.places[0].site == "lift"
    assert certain(found) <= {FRICTION}


def test_torques_below_any_limit_are_not_said_to_be_cut_off() -> None:
    assert "cut off" not in sentence(diagnose_motion(dry(), seed=0))


def number(found: MotionDiagnosis, effect: str, where: str, name: str) -> float:
    (one,) = [one for one in found.fit.findings if one.at.pair == [effect, where]]
    return one.numbers[name][0]


@pytest.mark.parametrize("factor", [-1.0, -0.8])
@pytest.mark.parametrize("joint", [LIFT, ELBOW])
def test_torques_of_one_joint_that_have_the_wrong_sign_are_read_as_their_opposites(joint: int, factor: float) -> None:
    tau = dry().tau.copy()
    tau[:, joint] *= factor
    found = diagnose_motion(replace(dry(), tau=tau), seed=0)
    assert found.verdict == "explained"
    assert certain(found) == {("torque_constant", JOINTS[joint]), FRICTION}
    assert number(found, "torque_constant", JOINTS[joint], "factor") == pytest.approx(factor - 1.0, abs=0.03)
    assert number(found, *FRICTION, "torque") == pytest.approx(4.0 * (abs(factor) if joint == ELBOW else 1.0), abs=0.2)


def test_a_wrong_sign_is_found_beside_a_limit() -> None:
    read = -dry().tau[:, LIFT]
    found = with_lift(np.minimum(read, 0.5 * read.max()))
    assert ("torque_constant", "lift") in certain(found) <= {("torque_constant", "lift"), FRICTION}
    assert "Torques of lift are cut off" in sentence(found)


def test_torques_that_all_have_the_wrong_sign_are_of_one_cause() -> None:
    found = diagnose_motion(replace(dry(), tau=-dry().tau), seed=0)
    assert found.verdict == "explained"
    assert certain(found) == {("torque_constant", "joints"), FRICTION}
    assert number(found, "torque_constant", "joints", "factor") == pytest.approx(-2.0, abs=0.03)


@pytest.mark.parametrize("gravity", [(9.81, 0.0, 0.0), (0.0, 5.0, -8.44), (0.0, 0.0, 9.81)])
def test_gravity_that_is_not_as_stated_is_named_and_nothing_else(gravity: tuple[float, float, float]) -> None:
    log = record(World(gravity=gravity, dry={"elbow": 4.0}), series=4, seconds=5.0, seed=5)
    found = diagnose_motion(replace(log, command=np.full_like(log.q, np.nan)), seed=0)
    assert found.verdict == "explained"
    assert certain(found) == {("gravity_direction", "base"), FRICTION}
    assert [number(found, "gravity_direction", "base", axis) for axis in "xyz"] == pytest.approx(gravity, abs=0.1)


def test_slow_motions_do_not_tell_an_arm_that_hangs_from_torques_of_the_wrong_sign() -> None:
    slow = replace(dry(), time_s=6.0 * dry().time_s)
    noise = 0.05 * np.random.default_rng(0).normal(size=slow.q.shape)
    found = diagnose_motion(replace(slow, tau=noise - slow.robot.gravity_torques(slow.q)), seed=0)
    (one,) = found.fit.findings
    pairs = [tuple(at.pair) for at in (one.at, *one.rivals)]
    assert sorted(pairs) == [("gravity_direction", "base"), ("torque_constant", "joints")]
    assert one.probability == pytest.approx(0.5)
