"""What motions could tell is said before they are recorded, and holds once they are."""

import json
from dataclasses import replace
from functools import cache

import numpy as np
import pytest
from moved_arms import simulated, written

from robolaser.cli import main
from robolaser.motion.diagnosis import diagnose_motion
from robolaser.motion.log import MotionLog
from robolaser.motion.plan import MotionPlan, plan_motion

MOTIONS = simulated(seconds=2.5, rate_hz=50.0, series=6, seed=4)


def commands_only(log: MotionLog) -> MotionLog:
    none = np.full_like(log.q, np.nan)
    return replace(log, q=none, qd=none, tau=none, load=none)


@cache
def plan_of_motions() -> MotionPlan:
    return plan_motion(commands_only(MOTIONS))


def size_of(plan: MotionPlan, effect: str, where: str) -> float | None:
    return next(one.size for one in plan.limits if (one.at.effect.name, one.at.where) == (effect, where))


@pytest.mark.parametrize(
    ("effect", "where", "others"),
    [
        ("offset", "lift", ("tau", "load")),
        ("dead_time", "pan", ("tau", "load")),
        ("viscous_friction", "lift", ("command", "load")),
        ("coulomb_friction", "elbow", ("command", "load")),
        ("payload", "tool", ("command", "load")),
    ],
)
def test_twice_the_planned_size_is_found_or_taken_for_what_the_plan_names(effect, where, others):
    plan = plan_of_motions()
    size = size_of(plan, effect, where)
    log = simulated(seconds=2.5, rate_hz=50.0, series=6, seed=4, effects={f"{effect}:{where}": 2.0 * size})
    log = replace(log, **{name: np.full_like(log.q, np.nan) for name in others})
    found = diagnose_motion(log, seed=0).fit.findings
    told = {str(at) for one in found for at in (one.at, *one.rivals)}
    alike = next(one.alike for one in plan.limits if str(one.at) == f"{effect} at {where}")
    assert told & {f"{effect} at {where}", *map(str, alike)}


def test_an_arm_that_never_moves_shows_no_friction():
    plan = plan_motion(replace(commands_only(MOTIONS), command=np.zeros_like(MOTIONS.command) + 0.3))
    assert all(one.size is None for one in plan.limits if one.at.effect.cause == "friction")


def test_play_is_not_distinguished_from_a_dead_zone_by_the_servos_own_encoder():
    plan = plan_of_motions()
    alike = next(one.alike for one in plan.limits if str(one.at) == "play at lift")
    assert "dead_zone at lift" in map(str, alike)
    assert any("behind the gear" in words for words in plan.next_motions)


def test_a_clock_is_not_distinguished_from_servos_that_are_late_unless_the_arm_is_moved_by_hand():
    plan = plan_of_motions()
    (clock,) = [
        one for one in plan.limits if str(one.at) == "clock_shift at timing" and one.at.effect.rows == "tracking"
    ]
    assert "dead_time" in {one.effect.name for one in clock.alike}
    assert any(words.startswith("Move the arm by hand") for words in plan.next_motions)


def test_slower_motions_show_less_of_a_delay():
    slow = replace(MOTIONS, time_s=5.0 * MOTIONS.time_s)
    fast, late = (size_of(plan, "dead_time", "pan") for plan in (plan_of_motions(), plan_motion(slow)))
    assert late > 1.5 * fast


def test_readings_change_nothing():
    """Whatever an arm did, its plan is that of its commands."""
    assert plan_motion(replace(commands_only(MOTIONS), q=MOTIONS.q + 0.1)).to_dict() == plan_of_motions().to_dict()


def test_the_command_plans_from_commands_alone(tmp_path, capsys):
    written(commands_only(MOTIONS), tmp_path / "log")
    assert main(["plan", str(tmp_path / "log"), "--json"]) == 0
    assert "dead_zone" in {one["effect"] for one in json.loads(capsys.readouterr().out)["limits"]}
    assert main(["plan", str(tmp_path / "log")]) == 0
    assert "viscous friction" in capsys.readouterr().out
    assert main(["diagnose", str(tmp_path / "log"), "--output", str(tmp_path / "why")]) == 1
    assert "no column q_<joint>" in capsys.readouterr().err
