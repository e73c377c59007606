"""Noise that remembers itself is no gap, and what follows the motion is one, however much noise is beside it."""

from collections.abc import Callable
from dataclasses import replace
from functools import cache

import numpy as np
import pytest
from moved_arms import JOINTS, simulated

from robolaser.motion.diagnosis import MotionDiagnosis, diagnose_motion
from robolaser.motion.log import MotionLog
from robolaser.motion.patterns import Patterns

ELBOW = JOINTS.index("elbow")
NOISE_RAD = 1e-3
MEMORY = 15  # rows over which noise is smooth


def slow_noise(shape: tuple[int, int], seed: int) -> np.ndarray:
    """Of a bell of rows, which neighbours hardly differ by."""
    bell = np.hanning(MEMORY)
    white = np.random.default_rng(seed).normal(size=(shape[0] + MEMORY - 1, shape[1]))
    columns = [np.convolve(column, bell, "valid") for column in white.T]
    return NOISE_RAD / np.linalg.norm(bell) * np.stack(columns, axis=1)


@cache
def log_of(lag_s: float = 0.0) -> MotionLog:
    log = simulated(seconds=2.5, rate_hz=50.0, series=50, effects={"lag:lift": lag_s}, seed=2)
    none = np.full_like(log.q, np.nan)
    return replace(log, q=log.q + slow_noise(log.q.shape, 7), tau=none, load=none)


def found_in(log: MotionLog, patterns: np.ndarray | float = 0.0) -> MotionDiagnosis:
    return diagnose_motion(replace(log, q=log.q + patterns), seed=0)


def test_a_sound_arm_whose_readings_have_slow_noise_has_no_gap() -> None:
    found = found_in(log_of())
    assert found.verdict == "no_gap"
    assert found.fit.gaps[0].whole("noise_floor") == pytest.approx(NOISE_RAD, rel=0.05)


def test_a_gap_is_explained_where_slow_noise_is_left() -> None:
    found = found_in(log_of(0.03))
    assert found.verdict == "explained"
    assert [one.at.pair for one in found.fit.findings] == [["lag", "lift"]]


def of_posture_direction_and_time(log: MotionLog) -> np.ndarray:
    """At each joint another one."""
    pan, _, elbow, _ = log.command.T
    columns = np.sin(20.0 * pan), np.sign(np.gradient(elbow)), (elbow > 0.2) - 0.5, 3.0 * np.exp(-log.time_s / 3.0)
    return np.stack(columns, axis=1)


def of_size(log: MotionLog) -> np.ndarray:
    """Noise that grows with the speed."""
    speed = np.concatenate([np.gradient(log.command[rows], log.step_s, axis=0) for rows in log.rows_of_runs])
    return np.random.default_rng(3).normal(size=log.q.shape) * np.abs(speed) / 0.2


@pytest.mark.parametrize("patterns", [of_posture_direction_and_time, of_size])
def test_what_follows_the_motion_is_unexplained_beside_slow_noise(patterns: Callable[[MotionLog], np.ndarray]) -> None:
    log = log_of()
    found = found_in(log, NOISE_RAD * patterns(log))
    assert found.verdict == "unexplained"
    assert {place.site for place in found.places} == {*JOINTS}  # none of them is noise


@pytest.mark.parametrize(("rows", "known"), [(6_250, True), (400, False)])
def test_few_rows_do_not_say_that_what_is_left_is_noise(rows: int, known: bool) -> None:
    log = log_of()
    some = log.of_rows(np.arange(len(log)) < rows)
    patterns = Patterns(some.run, some.time_s, some.command, np.zeros_like(some.q))
    assert patterns.is_noise((some.q - some.command)[:, ELBOW], ELBOW) is known


def test_noise_that_grows_with_speed_is_no_lag() -> None:
    """Nor anything else that lowers no error on motions that were not seen."""
    log = simulated(seconds=2.5, rate_hz=50.0, series=36, seed=2)
    none = np.full_like(log.q, np.nan)
    speed = np.abs(np.gradient(log.command, log.step_s, axis=0))  # runs begin and end with a jump
    shaken = log.q + 1e-3 * speed * np.random.default_rng(7).normal(size=log.q.shape)
    found = diagnose_motion(replace(log, q=shaken, tau=none, load=none), seed=0)
    assert found.fit.findings == ()
    (gap,) = found.fit.gaps
    assert (gap.noise_floor <= gap.after).all()
