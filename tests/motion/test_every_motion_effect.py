"""What every effect on moving arms must satisfy."""

from dataclasses import replace

import numpy as np
import pytest
from moved_arms import simulated

from robolaser.motion.diagnosis import diagnose_motion
from robolaser.motion.effect import MotionEffect
from robolaser.motion.effects import MOTION_EFFECTS
from robolaser.motion.log import MotionLog
from robolaser.motion.result_json import motion_json

CLASSES = {"timing", "servo", "friction", "dynamics", "transmission"}
SIZES = {
    "clock_shift": -0.02, "dead_time": 0.04, "lag": 0.06, "range_limit": -0.2, "speed_limit": 0.3, "droop": -0.004,
    "payload": 2.0, "link_inertia": 0.3, "coupled_friction": 3.0, "load_friction": 0.2, "torque_constant": 0.2,
    "stribeck_friction": 3.0, "asymmetric_friction": 2.0, "gear_spring": 1e-4, "gear_ripple": 4e-4,
    "gear_ratio": 2e-3, "lost_motion": 8e-4,
}  # fmt: skip
"""At one joint, where that differs from twice the usual size."""
TELLING = {"lag": "inertia", "link_inertia": "mass_z"}
"""The number that shows, where that is not the first."""
EFFECTS = {f"{one.name} {one.form or one.rows}": one for one in MOTION_EFFECTS}


def of_one_kind(log: MotionLog, rows: str) -> MotionLog:
    """Without what other kinds of rows are made of."""
    none = np.full_like(log.q, np.nan)
    made_of = {"tracking": "command", "torque": "tau", "load": "load"}
    return replace(log, **{name: none for kind, name in made_of.items() if kind != rows})


@pytest.fixture(params=EFFECTS)
def effect(request: pytest.FixtureRequest) -> MotionEffect:
    return EFFECTS[request.param]


def test_it_has_words_a_source_and_a_class(effect: MotionEffect) -> None:
    assert effect.cause in CLASSES
    assert effect.clause[0].islower()
    assert effect.remedy.endswith(".")
    assert len(effect.reference) > 10


def test_its_rivals_are_effects_on_the_same_rows(effect: MotionEffect) -> None:
    assert set(effect.rivals) <= {one.name for one in MOTION_EFFECTS if one.rows == effect.rows}


def test_it_is_found_where_it_is_simulated(effect: MotionEffect) -> None:
    first = next((one for one in effect.numbers if one.name == TELLING.get(effect.name)), effect.numbers[0])
    size = SIZES.get(effect.name, 2.0 * first.usual)
    place = effect.site if effect.site != "joint" else "lift"
    name = f"{effect.name}:{place}.{first.name}"
    more = {f"{effect.name}:{place}.time": 0.06, name: 2e-3}  # a lag of second order is one of the first, too
    asked = more if effect.name == "lag" and effect.form else {name: size}
    if effect.name == "clock_shift" and effect.rows != "tracking":
        log = simulated(seconds=2.5, rate_hz=50.0, series=8, seed=1)
        late = "load" if effect.rows == "load" else "tau"
        log = replace(log, **{late: np.roll(getattr(log, late), 2, axis=0)})
    else:
        log = simulated(seconds=2.5, rate_hz=50.0, series=8, effects=asked, seed=1)
    found = motion_json(diagnose_motion(of_one_kind(log, effect.rows), seed=0))
    told = {(one["effect"], one["where"]): one["probability"] for one in found["effects"]}
    rivals = {tuple(rival) for one in found["effects"] for rival in one["indistinguishable_from"]}
    assert told.get((effect.name, place), 0.0) >= 0.5 or (effect.name, place) in rivals
