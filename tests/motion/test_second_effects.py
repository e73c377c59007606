"""An effect that is small beside another one at its joint is named, too."""

from dataclasses import replace

import numpy as np
import pytest
from moved_arms import JOINTS, World, record
from plain_servos import late_arm

from robolaser.motion.diagnosis import diagnose_motion

LAG_S = 0.15


@pytest.mark.parametrize(
    ("number", "size", "effect"),
    [("zero", 0.003, "offset"), ("dead", 0.002, "dead_zone"), ("dead", 0.004, "dead_zone")],
)
def test_what_a_joint_has_beside_a_long_lag_is_named_at_its_size(number: str, size: float, effect: str) -> None:
    """It explains less than a thousandth of the error, and half of what the lag leaves."""
    found = diagnose_motion(late_arm(lag_s=LAG_S, **{number: size}), seed=0)
    numbers = {one.at.effect.name: next(iter(one.numbers.values()))[0] for one in found.fit.findings}
    assert found.verdict == "explained"
    assert numbers["lag"] == pytest.approx(LAG_S, rel=0.01)
    assert numbers[effect] == pytest.approx(size, rel=0.01)
    (gap,) = found.fit.gaps
    assert gap.after[JOINTS.index("lift")] < 2.0 * gap.noise_floor[JOINTS.index("lift")]


@pytest.mark.parametrize("friction", [1.0, 2.0])
def test_friction_beside_a_heavy_payload_is_named_at_its_size(friction: float) -> None:
    log = record(World(payload_kg=5.0, dry={"lift": friction}), series=4, seconds=5.0)
    found = diagnose_motion(replace(log, command=np.full_like(log.q, np.nan)), seed=0)
    numbers = {tuple(one.at.pair): next(iter(one.numbers.values()))[0] for one in found.fit.findings}
    assert set(numbers) == {("payload", "tool"), ("coulomb_friction", "lift")}
    assert numbers["payload", "tool"] == pytest.approx(5.0, rel=0.005)
    assert numbers["coulomb_friction", "lift"] == pytest.approx(friction, rel=0.02)
