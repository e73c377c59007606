"""Motors take their time: they ramp up and down, and are half way in half the time."""

import numpy as np
import pytest

from robolaser.emulator.controller import RAMP, way_gone


def test_speed_rises_stays_and_falls() -> None:
    assert [way_gone(share) for share in (0.0, 0.5, 1.0)] == pytest.approx([0.0, 0.5, 1.0])
    shares = np.linspace(0, 1, 1001)
    speed = np.gradient([way_gone(share) for share in shares], shares)
    assert np.all(np.diff(speed[shares < RAMP]) > 0)
    assert np.allclose(speed[(shares > RAMP + 0.01) & (shares < 1 - RAMP - 0.01)], 1 / (1 - RAMP))
    assert np.all(np.diff(speed[shares > 1 - RAMP + 0.01]) < 0)
