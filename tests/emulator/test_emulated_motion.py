"""Motors take their time, and stand where they were stopped."""

import numpy as np
import pytest

from robolaser.emulator.joints import RAMP, Axis, angles, least_seconds, rest_s, way_gone


@pytest.fixture
def rng() -> np.random.Generator:
    return np.random.default_rng(7)


def test_half_the_way_is_gone_in_half_the_time() -> None:
    assert way_gone(0.0) == 0.0
    assert way_gone(0.5) == pytest.approx(0.5)
    assert way_gone(1.0) == 1.0


def test_speed_rises_stays_and_falls() -> None:
    shares = np.linspace(0, 1, 1001)
    speed = np.gradient([way_gone(share) for share in shares], shares)
    assert np.all(np.diff(speed[shares < RAMP]) > 0)
    assert np.allclose(speed[(shares > RAMP + 0.01) & (shares < 1 - RAMP - 0.01)], 1 / (1 - RAMP))
    assert np.all(np.diff(speed[shares > 1 - RAMP + 0.01]) < 0)


def test_the_fastest_speed_is_not_exceeded(rng: np.random.Generator) -> None:
    for goal in rng.uniform(-2, 2, 20):
        axis = Axis(0.3)
        axis.queue(goal, 0.0, least_seconds(goal - 0.3, 0.5))
        at = np.array([axis.at(t) for t in np.arange(0, axis.free_s + 0.1, 1e-3)])
        assert np.abs(np.diff(at) / 1e-3).max() <= 0.5 * (1 + 1e-9)
        assert at[-1] == goal


def test_a_queue_is_gone_through_in_order() -> None:
    axis = Axis(0.0)
    for goal in (1.0, -1.0, 0.5):
        axis.queue(goal, axis.free_s if axis.free_s > 0 else 0.0, 2.0)
    assert [axis.at(t) for t in (2.0, 4.0, 6.0, 100.0)] == [1.0, -1.0, 0.5, 0.5]
    assert rest_s([axis]) == 6.0


def test_halted_it_stands_and_forgets_its_queue(rng: np.random.Generator) -> None:
    for halt in rng.uniform(0, 4, 20):
        axis = Axis(0.0)
        axis.queue(1.0, 0.0, 2.0)
        axis.queue(0.0, 2.0, 2.0)
        where = axis.at(halt)
        axis.halt(halt)
        assert axis.at(halt) == axis.at(halt + 50) == axis.goal == pytest.approx(where)
        axis.queue(0.7, halt + 50, 1.0)
        assert axis.at(halt + 51) == 0.7


def test_jammed_it_stays_whatever_it_is_told() -> None:
    axis = Axis(0.0)
    axis.queue(1.0, 0.0, 2.0)
    axis.jam(1.0)
    axis.queue(-1.0, 2.0, 2.0)
    assert axis.jammed
    assert angles([axis], 9.0) == pytest.approx([0.5])
