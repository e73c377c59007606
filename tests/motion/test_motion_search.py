"""The search for effects: it ends, whatever the models of its rows are worth."""

from collections.abc import Sequence
from dataclasses import replace
from itertools import count

import numpy as np
import pytest
from moved_arms import JOINTS, simulated

import robolaser
from robolaser.motion.effect import At
from robolaser.motion.effects import MOTION_EFFECTS
from robolaser.motion.evidence import Fitted
from robolaser.motion.kind_diagnoses import _with_twin
from robolaser.motion.selection import SelectedEffect, search, side_by_side
from robolaser.robot.by_name import find_robot

FRICTION, LINK = (
    At(next(one for one in MOTION_EFFECTS if one.name == name), "elbow", 0)
    for name in ("coulomb_friction", "link_inertia")
)
MODELS = {
    frozenset[At](): (100.0, 1.0),
    frozenset({FRICTION}): (90.0, 0.8),
    frozenset({LINK}): (float("inf"), 0.101),
    frozenset({FRICTION, LINK}): (50.0, 0.1),
}
"""Score and squares. The link has a negative mass unless there is friction beside it, which explains little then."""


class FewRounds:
    """Rows whose models are known, and which are not asked without end."""

    def __init__(self) -> None:
        self.rounds = count()

    def fit(self, asked: Sequence[tuple[int, tuple[At, ...]]]) -> list[Fitted]:
        assert next(self.rounds) < 50
        models = [(effects, *MODELS[frozenset(effects)]) for _, effects in asked]
        return [Fitted(effects, (), (), score, np.array([squares])) for effects, score, squares in models]


def test_an_effect_stays_without_which_no_model_is_possible():
    (found,) = side_by_side(FewRounds().fit, [search([FRICTION, LINK], 0.01)])
    assert set(found.model.effects) == {FRICTION, LINK}


def test_a_mass_on_a_joint_s_axis_is_certain_as_a_kind_and_may_be_either_link_s():
    effects = {"link_inertia:elbow_joint.mass": 0.8}
    log = simulated(seconds=20.0, rate_hz=50.0, robot=find_robot("ur5"), effects=effects, seed=1)
    none = np.full_like(log.q, np.nan)
    found = robolaser.diagnose(replace(log, command=none, load=none), seed=0).to_dict()
    (one,), (kind,) = found["effects"], found["kinds"]
    assert "elbow_joint" in {one["where"], *(where for _, where in one["indistinguishable_from"])}
    assert one["probability"] <= 0.5
    assert (kind["effect"], kind["probability"]) == ("link_inertia", pytest.approx(1.0, abs=1e-2))
    assert " or elbow_joint)" in found["sentence"] or "(elbow_joint or " in found["sentence"]


@pytest.mark.parametrize(("seconds", "rate_hz"), [(5.0, 100.0), (10.0, 50.0)])
def test_a_model_of_fewer_numbers_that_leaves_more_is_not_certain_where_both_are_within_the_error_of_models(
    seconds, rate_hz
):
    effects = {"link_inertia:elbow_joint.mass": 0.8}
    log = simulated(seconds=seconds, rate_hz=rate_hz, robot=find_robot("ur5"), effects=effects, seed=1)
    none = np.full_like(log.q, np.nan)
    (one,) = robolaser.diagnose(replace(log, command=none, load=none), seed=0).to_dict()["effects"]
    assert one["probability"] <= 0.5
    assert "link_inertia" in {one["effect"], *(name for name, _ in one["indistinguishable_from"])}


def test_a_dead_time_of_less_than_half_a_row_is_no_longer_lag():
    log = simulated(seconds=2.5, series=12, robot=find_robot("ur5e"), effects={"dead_time:elbow_joint": 0.003}, seed=4)
    log = replace(log, tau=np.full_like(log.q, np.nan), load=np.full_like(log.q, np.nan))
    (one,) = robolaser.diagnose(log, seed=0).to_dict()["effects"]
    assert (one["effect"], one["where"]) == ("dead_time", "elbow_joint")
    assert one["parameters"]["delay"]["value"] == pytest.approx(0.003, rel=1e-3)
    assert one["indistinguishable_from"] == [["lag", "elbow_joint"]]


@pytest.mark.parametrize(
    ("name", "joint", "number", "twin"),
    [
        ("play", 1, ("half_width", 0.005), "dead_zone"),
        ("lag", 1, ("time", 0.015), "dead_time"),
        ("lag", 1, ("time", 0.05), ""),
        ("link_inertia", 3, ("mass", 1.0), "payload"),
        ("link_inertia", 1, ("mass", 1.0), ""),
    ],
)
def test_what_no_such_rows_distinguish_is_no_likelier_than_the_other(name, joint, number, twin):
    log = simulated(seconds=1.0, series=1)
    candidates = [At(one, JOINTS[joint], joint) for one in MOTION_EFFECTS if not one.form and one.name != "clock_shift"]
    at = next(at for at in candidates if at.effect.name == name)
    found = SelectedEffect(at, 0.99, 0.0, None, (), {number[0]: (number[1], 1e-4, "")})
    found = _with_twin(found, candidates, log)
    assert found.probability == (0.5 if twin else 0.99)
    assert [rival.effect.name for rival in found.rivals] == ([twin] if twin else [])


def test_a_tool_whose_centre_is_off_its_flange_is_a_payload_or_a_change_of_the_last_link():
    effects = {"payload:tool": 1.0, "payload:tool.mass_x": 0.2, **dict.fromkeys(LAST_TURNS, 0.04)}
    log = simulated(seconds=5.0, rate_hz=50.0, series=6, effects=effects, seed=1)
    none = np.full_like(log.q, np.nan)
    found = robolaser.diagnose(replace(log, command=none, load=none), seed=0).to_dict()
    (one,), (cause,) = found["effects"], found["classes"]
    told = sorted([(one["effect"], one["where"]), *map(tuple, one["indistinguishable_from"])])
    assert told == [("link_inertia", "wrist"), ("payload", "tool")]
    assert one["probability"] <= 0.5
    assert (cause["class"], cause["probability"]) == ("dynamics", pytest.approx(1.0, abs=1e-2))


LAST_TURNS = ("link_inertia:wrist.yy", "link_inertia:wrist.zz")
