"""Servos that do not do as they are told, by their laws."""

from collections.abc import Callable

import numpy as np
import pytest

from robolaser.arrays import Array
from robolaser.emulator.servo_loop import STEP_S, ServoLoop
from robolaser.robot.by_name import find_robot

ARM = find_robot("scorbot_er7")
JOINT, COLUMN = "joint_2", 1
STEP_RAD = 0.2


def stepped(q: float = STEP_RAD) -> Callable[[float], Array]:
    """A command that jumps right after the beginning, at one joint."""
    return lambda now_s: np.eye(5)[COLUMN] * (q if now_s > 0.0 else 0.0)


def course(faults: dict[str, float], command: Callable[[float], Array], seconds: float = 2.0) -> tuple[Array, Array]:
    """Times and where the joint is."""
    loop = ServoLoop(ARM, {(name, JOINT): size for name, size in faults.items()})
    times = np.arange(0.0, seconds, STEP_S) + 1e-9
    times[0] = 0.0
    return times, np.array([loop.follow(command, float(t))[COLUMN] for t in times])


def test_without_faults_the_joint_is_where_it_is_told_to_be() -> None:
    _, q = course({}, stepped())
    np.testing.assert_allclose(q[1:], STEP_RAD, atol=1e-12)


def test_after_its_dead_time_a_joint_approaches_exponentially() -> None:
    times, q = course({"lag": 0.1, "dead_time": 0.05}, stepped())
    gone = np.maximum(times - 0.05, 0.0)
    np.testing.assert_allclose(q, STEP_RAD * -np.expm1(-gone / 0.1), atol=STEP_RAD * STEP_S / 0.1)


@pytest.mark.parametrize("sign", [-1.0, 1.0])
def test_a_joint_stops_at_the_near_edge_of_its_dead_zone(sign: float) -> None:
    _, q = course({"dead_zone": 0.03, "lag": 0.05}, stepped(sign * STEP_RAD))
    assert q[-1] == pytest.approx(sign * (STEP_RAD - 0.03), abs=1e-6)
    _, q = course({"dead_zone": 0.03, "lag": 0.05}, stepped(sign * 0.02))
    assert (q == 0.0).all()


def test_a_joint_sinks_by_its_compliance_for_each_newton_metre() -> None:
    compliance = 1e-3
    _, q = course({"droop": compliance, "lag": 0.05}, stepped())
    rests = np.eye(5)[COLUMN] * q[-1]
    assert q[-1] == pytest.approx(STEP_RAD - compliance * ARM.gravity_torques(rests)[COLUMN], abs=1e-6)
