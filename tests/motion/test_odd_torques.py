"""Torques of arms that MuJoCo moves, read at their limits, with a wrong sign or under another gravity than stated."""

from dataclasses import replace
from functools import cache

import numpy as np
import pytest
from moved_arms import JOINTS, World, record

from robolaser.motion.diagnosis import MotionDiagnosis, diagnose_motion
from robolaser.motion.log import MotionLog
from robolaser.motion.result_json import CERTAIN, motion_json, sentence

LIFT = JOINTS.index("lift")


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
    assert certain(found) <= {("coulomb_friction", "elbow")}
    assert f"Torques of lift are cut off at {most:.3g} Nm" in sentence(found)


def test_torques_that_bend_towards_a_limit_are_of_no_certain_cause() -> None:
    read = dry().tau[:, LIFT]
    most = 0.5 * np.abs(read).max()
    found = with_lift(most * np.tanh(read / most))
    assert found.verdict == "unexplained"
    assert found.places[0].site == "lift"
    assert certain(found) <= {("coulomb_friction", "elbow")}


def test_torques_below_any_limit_are_not_said_to_be_cut_off() -> None:
    assert "cut off" not in sentence(diagnose_motion(dry(), seed=0))
