"""Torques of arms that MuJoCo moves, read at their limits, with a wrong sign or under another gravity than stated."""

from dataclasses import replace
from functools import cache

import numpy as np
import pytest
from moved_arms import JOINTS, World, record

from robolaser.errors import DataError
from robolaser.estimation.certainty import CERTAIN
from robolaser.motion.diagnosis import MotionDiagnosis, diagnose_motion
from robolaser.motion.log import MotionLog
from robolaser.motion.result_json import motion_json, sentence

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


@pytest.mark.parametrize("share", [0.3, 0.9])
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


@pytest.mark.parametrize(("joint", "factor"), [(LIFT, -1.0), (ELBOW, -0.8)])
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


@pytest.mark.parametrize("gravity", [(0.0, 5.0, -8.44), (0.0, 0.0, 9.81)])
def test_gravity_that_is_not_as_stated_is_named_and_nothing_else(gravity: tuple[float, float, float]) -> None:
    log = record(World(gravity=gravity, dry={"elbow": 4.0}), series=4, seconds=5.0, seed=5)
    found = diagnose_motion(replace(log, command=np.full_like(log.q, np.nan)), seed=0)
    assert found.verdict == "explained"
    assert certain(found) == {("gravity_direction", "base"), FRICTION}
    assert [number(found, "gravity_direction", "base", axis) for axis in "xyz"] == pytest.approx(gravity, abs=0.1)


@cache
def loaded(kg: float = 1.5) -> MotionLog:
    log = record(World(payload_kg=kg, dry={"elbow": 4.0}), series=4, seconds=5.0, seed=5)
    return replace(log, command=np.full_like(log.q, np.nan))


@pytest.mark.parametrize(("joint", "kg"), [(0, 1.5), (ELBOW, 1.5), (LIFT, 5.0)])
def test_a_wrong_sign_is_found_beside_a_payload(joint: int, kg: float) -> None:
    found = diagnose_motion(
        replace(loaded(kg), tau=loaded(kg).tau * np.where(np.arange(4) == joint, -1.0, 1.0)), seed=0
    )
    assert found.verdict == "explained"
    assert certain(found) == {("torque_constant", JOINTS[joint]), ("payload", "tool"), FRICTION}
    assert number(found, "payload", "tool", "mass") == pytest.approx(kg, rel=0.01)


@pytest.mark.parametrize("wrong", [["lift"], [*JOINTS]])
def test_a_wrong_sign_is_found_beside_another_gravity(wrong: list[str]) -> None:
    gravity = (0.0, 5.0, -8.44)
    log = record(World(gravity=gravity, dry={"elbow": 4.0}), series=4, seconds=5.0, seed=5)
    tau = log.tau * [-1.0 if name in wrong else 1.0 for name in JOINTS]
    found = diagnose_motion(replace(log, command=np.full_like(log.q, np.nan), tau=tau), seed=0)
    where = wrong[0] if len(wrong) == 1 else "joints"
    assert found.verdict == "explained"
    assert certain(found) == {("torque_constant", where), ("gravity_direction", "base"), FRICTION}
    assert [number(found, "gravity_direction", "base", axis) for axis in "xyz"] == pytest.approx(gravity, abs=0.1)


@pytest.mark.parametrize("joint", ["pan", "elbow"])
def test_a_wrong_sign_is_found_on_an_arm_that_hangs_too(joint: str) -> None:
    log = record(World(gravity=(0.0, 0.0, 9.81), dry={"elbow": 4.0}), series=4, seconds=5.0, seed=5)
    tau = log.tau * [-1.0 if name == joint else 1.0 for name in JOINTS]
    found = diagnose_motion(replace(log, command=np.full_like(log.q, np.nan), tau=tau), seed=0)
    assert found.verdict == "explained"
    assert certain(found) == {("torque_constant", joint), ("gravity_direction", "base"), FRICTION}


def test_a_payload_is_as_heavy_where_torques_are_per_cent_of_rated_ones() -> None:
    rated_nm = np.array([150.0, 150.0, 100.0, 30.0])
    per_cent = replace(loaded(), tau=loaded().tau / rated_nm * 100.0)
    found = diagnose_motion(per_cent, ["torque_constant", "payload", "coulomb_friction"], seed=0)
    assert found.verdict == "explained"
    assert number(found, "payload", "tool", "mass") == pytest.approx(1.5, rel=0.03)
    factors = np.zeros(len(JOINTS))
    for one in found.fit.findings:
        if one.at.effect.name == "torque_constant":
            factors[slice(None) if one.at.where == "joints" else one.at.joint] += one.numbers["factor"][0]
    assert 1.0 + factors == pytest.approx(100.0 / rated_nm, rel=0.03)


@pytest.mark.parametrize(("unit", "per_nm"), [("mNm", 1000.0), ("Ncm", 100.0)])
def test_torques_in_a_servo_s_unit_are_read_as_such(unit: str, per_nm: float) -> None:
    found = diagnose_motion(replace(loaded(), tau=per_nm * loaded().tau), seed=0)
    assert found.verdict == "explained"
    assert certain(found) == {("torque_constant", "joints"), ("payload", "tool"), FRICTION}
    assert number(found, "payload", "tool", "mass") == pytest.approx(1.5, rel=0.01)
    assert number(found, "torque_constant", "joints", "factor") == pytest.approx(per_nm - 1.0, rel=0.01)
    assert f"torques are in {unit}, not in Nm" in sentence(found)


@pytest.mark.parametrize("factor", [[12.0, 12.0, 9.0, 5.0], [101.0] * 4, [0.098] * 4])
def test_currents_torques_before_the_gear_and_those_in_rare_units_say_nothing_of_masses(factor: list[float]) -> None:
    with pytest.raises(DataError, match=r"Torque rows are set aside: torques are [\d.]+ times .* are they in Nm"):
        diagnose_motion(replace(loaded(), tau=loaded().tau / factor), seed=0)


@pytest.mark.parametrize(
    ("joint", "torques_too", "kg"),
    [("lift", True, 0.0), ("elbow", False, 0.0), ("lift", False, 1.5), ("elbow", True, 1.5)],
)
def test_a_joint_that_turns_against_its_axis_is_named_and_no_link(joint: str, torques_too: bool, kg: float) -> None:
    log, side = loaded(kg), np.array([-1.0 if name == joint else 1.0 for name in JOINTS])
    found = diagnose_motion(replace(log, q=side * log.q, tau=side * log.tau if torques_too else log.tau), seed=0)
    expected = {("joint_direction", joint), FRICTION}
    expected |= {("payload", "tool")} if kg else set()
    expected |= set() if torques_too else {("torque_constant", joint)}
    assert found.verdict == "explained"
    assert certain(found) == expected


def test_the_error_at_the_flange_is_as_large_where_a_joint_turns_against_its_axis() -> None:
    log = record(World(dry={"elbow": 4.0}, zero={"elbow": 0.01}), series=4, seconds=5.0, seed=5)
    side = np.where(np.arange(len(JOINTS)) == LIFT, -1.0, 1.0)
    turned = replace(log, command=side * log.command, q=side * log.q, tau=side * log.tau)
    effects = ["offset", "coulomb_friction", "torque_constant"]
    whole, found = (diagnose_motion(one, effects, seed=0).fit.gap_mm for one in (log, turned))
    assert all(found[name] == pytest.approx(whole[name], rel=1e-9) for name in ("nominal", "calibrated", "after"))


def test_slow_motions_do_not_tell_an_arm_that_hangs_from_torques_of_the_wrong_sign() -> None:
    slow = replace(dry(), time_s=6.0 * dry().time_s)
    noise = 0.05 * np.random.default_rng(0).normal(size=slow.q.shape)
    found = diagnose_motion(replace(slow, tau=noise - slow.robot.gravity_torques(slow.q)), seed=0)
    (one,) = found.fit.findings
    pairs = [tuple(at.pair) for at in (one.at, *one.rivals)]
    assert sorted(pairs) == [("gravity_direction", "base"), ("torque_constant", "joints")]
    assert one.probability == pytest.approx(0.5)


def test_torques_that_pass_a_filter_are_late_and_no_friction_that_grows_with_speed() -> None:
    tau, step = dry().tau.copy(), dry().step_s
    for rows in dry().rows_of_runs:
        for row in range(rows.start + 1, rows.stop):
            tau[row] = tau[row - 1] + (tau[row] - tau[row - 1]) * step / (0.03 + step)
    found = diagnose_motion(replace(dry(), tau=tau), seed=0)
    assert {("clock_shift", "timing"), FRICTION} <= certain(found)
    assert "viscous_friction" not in {effect for effect, _ in certain(found)}
    (late,) = (one for one in found.fit.findings if one.at.where == "timing")
    assert late.numbers["delay"][0] == pytest.approx(0.03, rel=0.15)


def test_two_clocks_are_both_in_the_sentence() -> None:
    log = record(World(), series=4, seconds=5.0, seed=5)
    none = np.full_like(log.q, np.nan)
    tau, load = np.roll(log.tau, 2, axis=0), np.roll(log.q, 1, axis=0)
    said = sentence(diagnose_motion(replace(log, command=none, tau=tau, load=load), ["clock_shift"], seed=0))
    assert "torques are not read at the instant of the encoders" in said
    assert "the two encoders are not read at the same instant" in said
