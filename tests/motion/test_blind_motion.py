"""Arms that MuJoCo moves under a controller of these tests' own, diagnosed without a word about what is the matter."""

from dataclasses import replace
from functools import cache

import numpy as np
import pytest
from moved_arms import World, record

from robolaser.estimation.certainty import CERTAIN
from robolaser.motion import kind_diagnoses
from robolaser.motion.calibration import MotionFit, calibrate_motion
from robolaser.motion.diagnosis import MotionDiagnosis, diagnose_motion
from robolaser.motion.effect import At
from robolaser.motion.effects import MOTION_EFFECTS
from robolaser.motion.linear_rows import LinearRows
from robolaser.motion.log import MotionLog
from robolaser.motion.quantities import quantities
from robolaser.motion.result_json import motion_json

YY = 6  # of a link's ten numbers
SOUND, ODD = "nothing", "a reading bent by the cube of the angle"
CLOCKS = (0.0, 0.012, 0.004, 0.018)
WORLDS = {
    "readings stamped too early": (World(clock_s=(0.01,)), "timing", {"clock_shift"}),
    "clocks that begin anew, beside friction": (
        World(clock_s=CLOCKS, dry={"elbow": 4.0}),
        "timing",
        {"clock_shift", "coulomb_friction"},
    ),
    "a soft servo": (World(feeds_forward=False, bandwidth=25.0), "servo", {"lag", "droop"}),
    "a wrong zero": (World(zero={"elbow": 0.01}), "servo", {"offset"}),
    "a dead band": (World(dead={"lift": 0.01}, feeds_forward=False), "servo", {"dead_zone", "lag", "droop"}),
    "a slow drive": (World(top_speed={"pan": 0.5}), "servo", {"speed_limit"}),
    "friction": (
        World(damping={"lift": 6.0}, dry={"elbow": 4.0}),
        "friction",
        {"viscous_friction", "coulomb_friction", "dead_zone"},
    ),
    "a heavy rotor": (World(armature={"lift": 1.0}), "dynamics", {"rotor_inertia"}),
    "a payload": (World(payload_kg=1.5), "dynamics", {"payload", "droop", "lag"}),
    "a wrong torque constant": (World(gain={"lift": 1.1}), "dynamics", {"torque_constant"}),
    "a soft gear": (World(spring={"lift": 2e4}), "transmission", {"gear_spring", "rotor_inertia"}),
}
OTHERS = {SOUND: World(), ODD: World(wave={"pan": 0.05})}


@cache
def recorded(name: str) -> MotionLog:
    world = OTHERS.get(name) or WORLDS[name][0]
    runs, rate_hz = (4, 100) if len(world.clock_s) > 1 else (8, 50)  # the clock of each is told by its own rows
    return record(world, series=runs, seconds=20.0 / runs, seed=3, rate_hz=rate_hz)


@cache
def found_in(name: str) -> MotionDiagnosis:
    return diagnose_motion(recorded(name), seed=0)


def certain(found: MotionDiagnosis) -> set[str]:
    return {one["effect"] for one in motion_json(found)["kinds"] if one["probability"] >= CERTAIN}


@pytest.mark.parametrize("name", WORLDS)
def test_the_class_of_cause_is_named_and_nothing_false_for_certain(name: str) -> None:
    _, cause, true = WORLDS[name]
    found = found_in(name)
    classes = {one["class"]: one["probability"] for one in motion_json(found)["classes"]}
    assert classes.get(cause, 0.0) >= CERTAIN
    assert certain(found) <= true


def saturated(log: MotionLog) -> MotionLog:
    tau = log.tau.copy()
    tau[:, 1] = 60.0 * np.tanh(tau[:, 1] / 60.0)
    return replace(log, tau=tau)


def wobbling(log: MotionLog) -> MotionLog:
    q = log.q.copy()
    q[:, 0] += 0.005 * np.sin(q[:, 0] + 1.0)
    return replace(log, q=q)


UNKNOWN = {
    "a spring beside the joint": (World(pulled={"lift": 20.0}), None, "lift"),
    "a weak one, as small as errors of the form of torque models": (World(pulled={"lift": 4.0}), None, "lift"),
    "a spring at a wrist": (World(pulled={"wrist": 1.0}), None, "wrist"),
    "a torque sensor that saturates": (World(), saturated, "lift"),
    "an encoder's disc off its axis": (World(), wobbling, "pan"),
}


@pytest.mark.parametrize("name", UNKNOWN)
def test_no_smooth_effect_is_named_for_what_a_function_of_unknown_form_explains(name: str) -> None:
    world, read, joint = UNKNOWN[name]
    log = record(world, series=8, seconds=10.0, seed=3, rate_hz=50)
    found = diagnose_motion(read(log) if read else log, seed=0)
    assert found.verdict == "unexplained"
    assert found.places[0].site == joint
    result = motion_json(found)
    assert certain(found) == set()
    assert {one["class"] for one in result["classes"] if one["probability"] >= CERTAIN} == {"unknown"}


def test_an_arm_that_follows_its_model_has_no_gap() -> None:
    found = found_in(SOUND)
    assert found.verdict == "no_gap"
    assert found.fit.findings == ()


def test_what_no_effect_describes_is_unexplained_at_its_joint() -> None:
    found = found_in(ODD)
    assert found.verdict == "unexplained"
    assert certain(found) == set()
    assert found.places[0].site == "pan"


def test_the_gap_is_where_the_rows_that_have_one_show_it() -> None:
    (place, *_) = found_in("a wrong torque constant").places
    assert (place.site, place.share) == ("lift", pytest.approx(1.0, abs=0.05))


def test_the_error_at_the_flange_is_that_of_joints_that_err_together() -> None:
    gap = motion_json(found_in("a soft servo"))["gap_mm"]
    low, high = gap["after_ci95"]
    assert low <= gap["after"] <= high
    log = recorded("a soft servo")
    away = log.robot.forward(log.q[None])[0, :, :3, 3] - log.robot.forward(log.command[None])[0, :, :3, 3]
    assert gap["nominal"] == pytest.approx(1e3 * np.sqrt((away**2).sum(axis=1).mean()), rel=0.1)


def test_no_effect_that_rows_can_show_is_said_to_lack_them() -> None:
    missing = found_in("friction").not_testable
    assert "clock_shift" not in missing
    assert missing["gear_ratio"] == "no encoder behind the gear in the data"


@pytest.mark.parametrize(("factor", "odd"), [(1.0, False), (7.3, True)])
def test_torques_of_another_unit_are_said_to_be_odd(factor: float, odd: bool) -> None:
    log = recorded("friction")
    found = diagnose_motion(replace(log, tau=factor * log.tau), ["torque_constant"], seed=0)
    assert any("are they in Nm" in remark for remark in found.remarks) is odd


def test_one_wrong_scale_of_all_torques_is_named_in_place_of_links_and_single_drives() -> None:
    log = recorded(SOUND)
    alone = replace(log, command=np.full_like(log.q, np.nan), tau=1.1 * log.tau)
    (found,) = diagnose_motion(alone, seed=0).fit.findings
    assert found.at.pair == ["torque_constant", "joints"]
    assert found.numbers["factor"][0] == pytest.approx(0.1, abs=0.01)


def test_the_numbers_are_those_of_the_world() -> None:
    (payload,) = [one for one in found_in("a payload").fit.findings if one.at.effect.name == "payload"]
    mass, deviation, unit = payload.numbers["mass"]
    assert mass == pytest.approx(1.5, abs=0.02)
    assert unit == "kg"
    assert deviation < 0.05


def test_a_payload_that_is_stated_is_no_gap() -> None:
    log = record(World(payload_kg=1.5, bandwidth=120.0), series=4, seconds=5.0, seed=3)
    told = replace(log, command=np.full_like(log.command, np.nan), payload_kg=dict.fromkeys(log.series, 1.5))
    assert diagnose_motion(told, seed=0).verdict == "no_gap"
    unsaid = replace(told, payload_kg={})
    assert [one.at.effect.name for one in diagnose_motion(unsaid, seed=0).fit.findings] == ["payload"]


def test_the_clock_of_each_series_is_told() -> None:
    (clock,) = [
        one
        for one in found_in("clocks that begin anew, beside friction").fit.findings
        if one.at.effect.name == "clock_shift"
    ]
    told = [clock.numbers[f"run_{number}"][0] for number in range(len(CLOCKS))]
    assert np.subtract(told, np.mean(told)) == pytest.approx(np.mean(CLOCKS) - np.array(CLOCKS), abs=1e-3)


def test_readings_that_jump_are_no_all_clear() -> None:
    log = recorded(SOUND)
    jumps = np.random.default_rng(1).normal(0.0, 0.5, log.q.shape)
    none = np.full_like(log.q, np.nan)
    assert diagnose_motion(replace(log, q=log.q + jumps, tau=none), seed=0).verdict == "unexplained"


@pytest.mark.parametrize(("factor", "is_possible"), [(2.0, True), (-0.5, True), (-8.0, False)])
def test_a_link_of_negative_inertia_is_no_answer(factor: float, is_possible: bool) -> None:
    """Torques that only such a link would need are those of another cause."""
    of = quantities(recorded(SOUND), "torque")
    joint = of.log.joints.index("lift")
    change = np.where(np.arange(10) == YY, factor * of.inertial_numbers(joint), 0.0)
    link = next(At(one, "lift", joint) for one in MOTION_EFFECTS if one.name == "link_inertia")
    rows = LinearRows(of, np.where(np.isfinite(of.measured), of.regressor(joint) @ change, np.nan), [link])
    (fitted,) = rows.fit([(0, (link,))])
    assert np.isfinite(fitted.score) == is_possible


def clocks_of(clocks: tuple[float, ...], series: int) -> MotionFit:
    log = record(World(clock_s=clocks), series=series, seconds=5.0, seed=3)
    return calibrate_motion(replace(log, tau=np.full_like(log.q, np.nan)), ["clock_shift"], seed=0)


def test_the_clocks_of_a_long_log_are_told_in_all_of_its_series(monkeypatch: pytest.MonkeyPatch) -> None:
    """Also in those that are not searched for effects."""
    monkeypatch.setattr(kind_diagnoses, "_some_runs", lambda log: np.arange(0, len(log.series), 2))
    (clock,) = clocks_of(CLOCKS, 8).findings
    told = np.array([clock.numbers[f"run_{number}"][0] for number in range(8)])
    assert told - told.mean() == pytest.approx(np.mean(CLOCKS) - np.array(2 * CLOCKS), abs=1e-3)


@pytest.mark.parametrize("clocks", [(0.01,), CLOCKS])
def test_readings_that_lead_are_held_against_commands_that_the_log_has(clocks: tuple[float, ...]) -> None:
    (gap,) = clocks_of(clocks, 4).gaps
    assert gap.whole("after") < 2.0 * gap.whole("noise_floor")


def test_a_log_that_begins_amid_a_motion_shows_a_dead_time_and_no_lag() -> None:
    log = record(World(delay_s=0.02), series=8, seconds=2.5, seed=3, rate_hz=50)
    late = log.of_rows(log.time_s >= 1.0)
    found = diagnose_motion(replace(late, time_s=late.time_s - 1.0), seed=0)
    classes = {one["class"]: one["probability"] for one in motion_json(found)["classes"]}
    assert classes.get("timing", 0.0) >= CERTAIN
    assert certain(found) <= {"dead_time", "clock_shift"}
    assert {one.at.effect.name for one in found.fit.findings} <= {"dead_time", "clock_shift"}
