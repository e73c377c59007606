"""Rows that are lost, and values that a recorder holds from the row above, change no number of what is found."""

from collections.abc import Callable
from dataclasses import replace
from functools import cache

import numpy as np
import pytest
from moved_arms import JOINTS, World, record
from plain_servos import late_arm

from robolaser.errors import DataError
from robolaser.motion.diagnosis import MotionDiagnosis, diagnose_motion
from robolaser.motion.log import MotionLog
from robolaser.results.motion import MotionResult

LAG_S = 0.06
cached_arm = cache(late_arm)


def holes(log: MotionLog) -> np.ndarray:
    """A quarter of the rows, 0.4 s each time."""
    gone = np.zeros(len(log), dtype=bool)
    for start in np.random.default_rng(0).integers(0, len(log) - 40, 10):
        gone[start : start + 40] = True
    return gone


def without_commands(log: MotionLog) -> MotionLog:
    told = np.random.default_rng(0).random(len(log)) > 0.3
    return replace(log, command=np.where(told[:, None], log.command, np.nan))


def without(quantity: str, rows: np.ndarray, log: MotionLog) -> MotionLog:
    """The same without a quantity of the first two joints in some rows."""
    gone = rows[:, None] & (np.arange(len(JOINTS)) < (2 if quantity == "command" else 1))
    return replace(log, **{quantity: np.where(gone, np.nan, getattr(log, quantity))})


LOSSES: dict[str, Callable[[MotionLog], MotionLog]] = {
    "every second row": lambda log: log.of_rows(np.random.default_rng(0).random(len(log)) > 0.5),
    "holes of 0.4 s": lambda log: log.of_rows(~holes(log)),
    "a third of the commands": without_commands,
    "the commands of a series, moved by hand": lambda log: without("command", log.run == 0, log),
    "nearly all readings of another joint": lambda log: without("q", np.arange(len(log)) > 2, log),
}


def the_effect(found: MotionDiagnosis) -> tuple[str, str, float]:
    (one,) = found.fit.findings
    return *one.at.pair, next(iter(one.numbers.values()))[0]


@pytest.mark.parametrize("loss", LOSSES)
def test_a_lag_is_as_long_where_rows_are_lost(loss):
    found = diagnose_motion(LOSSES[loss](cached_arm(lag_s=LAG_S)), seed=0)
    assert the_effect(found) == ("lag", "lift", pytest.approx(LAG_S, rel=0.005))
    (gap,) = found.fit.gaps
    assert gap.after[JOINTS.index("lift")] < 0.01 * gap.calibrated[JOINTS.index("lift")]
    assert "Errors of lift" in MotionResult.of(found).files()["report.html"]


def test_readings_that_meet_no_command_but_at_the_ends_are_said_to_be_none():
    log = cached_arm(lag_s=LAG_S)
    with pytest.raises(DataError, match="meet only in rows at the ends of series"):
        diagnose_motion(replace(log, q=np.where(np.arange(len(log))[:, None] > 2, np.nan, log.q)), seed=0)


def test_holes_hide_no_lag_behind_a_dead_time():
    """0.4 s in which nobody knows the commands are no part of a motion."""
    log = late_arm(lag_s=0.03, delay_s=0.03)
    found = diagnose_motion(log.of_rows(~holes(log)), seed=0).fit.findings
    numbers = {one.at.effect.name: next(iter(one.numbers.values()))[0] for one in found}
    assert numbers == {"lag": pytest.approx(0.03, rel=0.02), "dead_time": pytest.approx(0.03, rel=0.02)}


def held(values: np.ndarray, rows: int = 2) -> np.ndarray:
    """As one has them who reads them anew in every so many rows of each run of 200."""
    row = np.arange(len(values))
    return values[row - row % 200 % rows]


@pytest.mark.parametrize(
    ("quantity", "rows", "said"), [("q", 3, "only repeat"), ("command", 3, "between them they are interpolated")]
)
def test_readings_that_repeat_add_no_delay_and_commands_that_repeat_shorten_no_lag(quantity, rows, said):
    log = cached_arm(lag_s=LAG_S)
    found = diagnose_motion(replace(log, **{quantity: held(getattr(log, quantity), rows)}), seed=0)
    assert the_effect(found) == ("lag", "lift", pytest.approx(LAG_S, rel=0.005))
    assert any(said in remark for remark in found.remarks)


def test_a_sound_arm_whose_commands_are_written_less_often_has_no_gap():
    log = cached_arm()
    assert diagnose_motion(replace(log, command=held(log.command)), seed=0).verdict == "no_gap"


def test_one_joint_that_is_read_half_as_often_is_not_late():
    log = cached_arm()
    q = log.q.copy()
    q[:, 2] = held(log.q)[:, 2]
    found = diagnose_motion(replace(log, q=q), seed=0)
    assert (found.verdict, found.fit.findings) == ("no_gap", ())
    assert any("elbow" in remark for remark in found.remarks)


@cache
def dry() -> MotionLog:
    log = record(World(dry={"elbow": 4.0}, damping={"lift": 6.0}), series=5, seconds=4.0, seed=5)
    return replace(log, command=np.full_like(log.q, np.nan))


@pytest.mark.parametrize("quantity", ["q", "tau"])
def test_torques_or_angles_that_repeat_make_no_other_friction(quantity):
    log = replace(dry(), **{quantity: held(getattr(dry(), quantity))})
    found = {tuple(one.at.pair): one.numbers for one in diagnose_motion(log, seed=0).fit.findings}
    assert set(found) == {("viscous_friction", "lift"), ("coulomb_friction", "elbow")}
    assert found["viscous_friction", "lift"]["factor"][0] == pytest.approx(6.0, rel=0.01)
    assert found["coulomb_friction", "elbow"]["torque"][0] == pytest.approx(4.0, rel=0.01)


def test_a_second_encoder_that_repeats_is_not_read_at_another_instant():
    log = record(World(spring={"lift": 2e4}), series=5, seconds=4.0, seed=5)
    none = np.full_like(log.q, np.nan)
    found = diagnose_motion(replace(log, command=none, tau=none, load=held(log.load)), seed=0)
    assert the_effect(found)[:2] == ("gear_spring", "lift")


def test_rounded_readings_of_a_slow_joint_are_all_read():
    log = cached_arm(lag_s=LAG_S)
    coarse = replace(log, q=0.0015 * np.round(log.q / 0.0015), time_s=2.0 * log.time_s)
    assert np.array_equal(coarse.as_read.q, coarse.q)


def test_readings_of_a_joint_that_sticks_and_slips_are_all_read():
    log, rng = cached_arm(), np.random.default_rng(0)
    rests = np.repeat(rng.normal(size=len(log)).cumsum(), rng.integers(3, 12, len(log)))[: len(log)]
    slipping = replace(log, q=np.where(np.arange(len(JOINTS)) == 1, rests[:, None], log.q))
    assert np.array_equal(slipping.as_read.q, slipping.q)
