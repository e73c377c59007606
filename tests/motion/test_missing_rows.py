"""What is missing in a log, or in the library, changes no number of what is there."""

from dataclasses import replace

import numpy as np
import pytest
from moved_arms import JOINTS, World, record, simulated

from robolaser.motion.calibration import calibrate_motion
from robolaser.motion.diagnosis import diagnose_motion
from robolaser.motion.log import MotionLog
from robolaser.motion.quantities import quantities

ELBOW = JOINTS.index("elbow")


@pytest.fixture(scope="module")
def log() -> MotionLog:
    whole = simulated(seconds=20.0, series=4, effects={"coulomb_friction:elbow": 5.0, "lag:pan": 0.03}, seed=1)
    return replace(whole, load=np.full_like(whole.q, np.nan))


def without_reading(log: MotionLog, row: int) -> MotionLog:
    q = log.q.copy()
    q[row, ELBOW] = np.nan
    return replace(log, q=q)


@pytest.mark.parametrize("row", [3, 700, 1999, 3998])
def test_one_missing_reading_costs_the_rows_around_it(log: MotionLog, row: int) -> None:
    whole, less = (np.isfinite(quantities(one, "torque").measured).sum() for one in (log, without_reading(log, row)))
    assert 0.98 * whole < less <= whole


def test_one_missing_reading_changes_no_friction(log: MotionLog) -> None:
    alone = replace(log, command=np.full_like(log.q, np.nan))
    gaps = [diagnose_motion(one, seed=0).fit.gaps[0] for one in (alone, without_reading(alone, 700))]
    assert gaps[1].whole("after") == pytest.approx(gaps[0].whole("after"), rel=0.05)


def test_a_joint_that_was_never_read_is_said_to_be_why_torques_say_nothing(log: MotionLog) -> None:
    q = log.q.copy()
    q[:, ELBOW] = np.nan
    (remark,) = diagnose_motion(replace(log, q=q).of_rows(log.time_s < 2.0), ["offset"], seed=0).remarks
    assert remark.startswith("Torque rows are set aside: there are no readings of elbow")


def test_the_torque_error_does_not_depend_on_which_effects_are_asked_for(log: MotionLog) -> None:
    heavy = replace(log, tau=log.tau + 4.0).of_rows(log.time_s < 3.0)
    asked = calibrate_motion(heavy, ["lag"], seed=0).gaps[1]
    (whole,) = diagnose_motion(replace(heavy, command=np.full_like(heavy.q, np.nan)), seed=0).fit.gaps
    assert asked.calibrated == pytest.approx(whole.calibrated, rel=1e-3)
    assert asked.whole("calibrated") > 3.9


@pytest.mark.parametrize("names", [("dead_time", "clock_shift"), ("clock_shift", "dead_time")])
def test_delays_of_a_servo_and_of_clocks_add_up(names: tuple[str, str]) -> None:
    log = simulated(seconds=20.0, series=1, effects=dict.fromkeys(names, 0.03), seed=1)
    speed = np.gradient(log.command[:, 0], log.step_s)
    assert -speed @ (log.q - log.command)[:, 0] / (speed @ speed) == pytest.approx(0.06, rel=0.02)


def test_a_dead_time_stays_one_where_rows_are_dropped() -> None:
    late = record(World(delay_s=0.035), series=8, seconds=2.5, seed=3, rate_hz=50)
    late = replace(late, tau=np.full_like(late.q, np.nan))
    fit = diagnose_motion(late.of_rows(np.random.default_rng(0).random(len(late)) > 0.07), seed=0).fit
    assert {one.at.pair[0] for one in fit.findings} == {"dead_time"}
    assert [one.numbers["delay"][0] for one in fit.findings] == pytest.approx([0.035] * len(JOINTS), abs=1e-3)
    assert fit.gaps[0].whole("after") < 2.0 * fit.gaps[0].whole("noise_floor")


def test_zeros_that_differ_from_run_to_run_change_no_lag(log: MotionLog) -> None:
    alone = replace(log, tau=np.full_like(log.q, np.nan), offset_per_series=True).of_rows(log.time_s < 3.0)
    zeros = np.array([[0.3], [-0.2], [0.1], [0.4]])[alone.run]
    fits = [calibrate_motion(one, ["lag:pan"], seed=0) for one in (alone, replace(alone, q=alone.q + zeros))]
    lags, errors = zip(*((fit.findings[0].numbers["time"][0], fit.gaps[0].calibrated) for fit in fits), strict=True)
    assert lags == pytest.approx([0.03, 0.03], rel=0.02)
    assert errors[1] == pytest.approx(errors[0], rel=1e-9)


@pytest.mark.parametrize("share", [0.02, 0.3])
def test_rows_that_were_lost_change_no_torque(log: MotionLog, share: float) -> None:
    some = log.of_rows(np.random.default_rng(0).random(len(log)) > share)
    whole, less = (quantities(one, "torque") for one in (log, some))
    assert len(less.q) > 0.9 * (1.0 - share) * len(whole.q)
    assert np.nanstd(less.measured - less.rigid) == pytest.approx(np.nanstd(whole.measured - whole.rigid), rel=0.02)


def test_a_pause_has_no_velocity(log: MotionLog) -> None:
    some = log.of_rows((log.time_s < 8.0) | (log.time_s > 8.9))
    whole, less = (quantities(one, "torque") for one in (log, some))
    assert np.nanstd(less.measured - less.rigid) == pytest.approx(np.nanstd(whole.measured - whole.rigid), rel=0.02)
