"""Waves of gears, by the ratios of strain wave gears that makers sell, once and twice a turn of the wave generator."""

from dataclasses import replace

import numpy as np
import pytest
from moved_arms import JOINTS, simulated

from robolaser.motion.diagnosis import diagnose_motion

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
