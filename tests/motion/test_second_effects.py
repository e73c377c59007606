"""An effect that is small beside another one at its joint is named, too, and the waves of gears that makers sell."""

from dataclasses import replace

import numpy as np
import pytest
from moved_arms import JOINTS, World, record, simulated
from plain_servos import late_arm

from robolaser.motion.diagnosis import diagnose_motion

LAG_S, LOST_RAD = 0.15, 1e-4


@pytest.mark.parametrize(("number", "size", "effect"), [("zero", 0.003, "offset"), ("dead", 0.002, "dead_zone")])
def test_what_a_joint_has_beside_a_long_lag_is_named_at_its_size(number: str, size: float, effect: str) -> None:
    """It explains less than a thousandth of the error, and half of what the lag leaves."""
    found = diagnose_motion(late_arm(lag_s=LAG_S, **{number: size}), seed=0)
    numbers = {one.at.effect.name: next(iter(one.numbers.values()))[0] for one in found.fit.findings}
    assert found.verdict == "explained"
    assert numbers["lag"] == pytest.approx(LAG_S, rel=0.01)
    assert numbers[effect] == pytest.approx(size, rel=0.01)
    (gap,) = found.fit.gaps
    assert gap.after[JOINTS.index("lift")] < 2.0 * gap.noise_floor[JOINTS.index("lift")]


def test_friction_beside_a_heavy_payload_is_named_at_its_size() -> None:
    log = record(World(payload_kg=5.0, dry={"lift": 1.0}), series=4, seconds=5.0)
    found = diagnose_motion(replace(log, command=np.full_like(log.q, np.nan)), seed=0)
    numbers = {tuple(one.at.pair): next(iter(one.numbers.values()))[0] for one in found.fit.findings}
    assert set(numbers) == {("payload", "tool"), ("coulomb_friction", "lift")}
    assert numbers["payload", "tool"] == pytest.approx(5.0, rel=0.005)
    assert numbers["coulomb_friction", "lift"] == pytest.approx(1.0, rel=0.02)


def test_errors_with_the_effects_found_are_those_of_the_named_ones_alone() -> None:
    """The wrist's friction is less than half a per cent of the largest torques: it is no gap, and is not named."""
    log = record(World(dry={"lift": 3.0, "wrist": 0.09}), series=4, seconds=5.0)
    found = diagnose_motion(replace(log, command=np.full_like(log.q, np.nan)), seed=0)
    (gap,), wrist = found.fit.gaps, JOINTS.index("wrist")
    assert [one.at.pair for one in found.fit.findings] == [["coulomb_friction", "lift"]]
    assert gap.after[wrist] == gap.calibrated[wrist] > 2.0 * gap.noise_floor[wrist]
    assert gap.after[LIFT] < 0.1 * gap.calibrated[LIFT]


def test_a_small_lost_motion_beside_a_spring_is_named() -> None:
    """It is a hundredth of the difference of the encoders, and most of what the spring leaves."""
    log = record(World(spring={"lift": 5e3}), series=5, seconds=4.0, seed=5)
    lift, load = JOINTS.index("lift"), log.load.copy()
    for rows in log.rows_of_runs:
        behind = log.q[rows.start, lift]
        for row in range(rows.start, rows.stop):
            behind = np.clip(behind, log.q[row, lift] - LOST_RAD, log.q[row, lift] + LOST_RAD)
            load[row, lift] += behind - log.q[row, lift]
    none = np.full_like(log.q, np.nan)
    found = diagnose_motion(replace(log, command=none, tau=none, load=load), seed=0)
    numbers = {tuple(one.at.pair): next(iter(one.numbers.values()))[0] for one in found.fit.findings}
    assert set(numbers) == {("gear_spring", "lift"), ("lost_motion", "lift")}
    assert numbers["gear_spring", "lift"] == pytest.approx(1.0 / 5e3, rel=0.01)
    assert numbers["lost_motion", "lift"] == pytest.approx(LOST_RAD, rel=0.3)


def test_a_spring_is_as_soft_where_the_motor_s_torque_turns_its_rotor_too() -> None:
    log = record(World(spring={"lift": 5e3}), series=5, seconds=4.0, seed=5)
    found = diagnose_motion(replace(log, command=np.full_like(log.q, np.nan)), seed=0)
    (spring,) = [one for one in found.fit.findings if one.at.effect.name == "gear_spring"]
    assert spring.numbers["compliance"][0] == pytest.approx(1.0 / 5e3, rel=0.01)


LIFT = JOINTS.index("lift")


@pytest.mark.parametrize("cycles", [50, 202])
def test_the_ripple_of_a_gear_is_named_at_its_joint(cycles: int) -> None:
    log = simulated(seconds=20.0, series=4, seed=4)
    none = np.full_like(log.q, np.nan)
    load = log.load.copy()
    wide = 1.6 * (log.q[:, LIFT] - log.q[:, LIFT].mean())  # over more than two radians
    q = log.q.copy()
    q[:, LIFT] = wide
    load[:, LIFT] = wide + (log.load - log.q)[:, LIFT] + 2e-4 * np.sin(cycles * wide + 0.3)
    found = diagnose_motion(replace(log, command=none, tau=none, q=q, load=load), seed=0)
    assert found.verdict == "explained"
    (one,) = found.fit.findings
    assert one.at.pair == ["gear_ripple", "lift"]
    assert one.numbers["cycles"][0] == cycles


@pytest.mark.parametrize("cycles", [1, 2])
def test_an_encoder_s_disc_that_is_not_centred_is_no_wrong_gear_ratio(cycles: int) -> None:
    log = simulated(seconds=10.0, rate_hz=50.0, series=4, seed=1)
    none = np.full_like(log.q, np.nan)
    load = log.load.copy()
    load[:, LIFT] += 3e-4 * np.sin(cycles * log.q[:, LIFT] + 0.5)
    found = diagnose_motion(replace(log, command=none, tau=none, load=load), seed=0)
    assert found.verdict == "explained"
    (one,) = found.fit.findings
    assert one.at.pair == ["gear_ripple", "lift"]
    assert one.numbers["cycles"][0] == cycles
    assert np.hypot(one.numbers["cosine"][0], one.numbers["sine"][0]) == pytest.approx(3e-4, rel=0.1)
