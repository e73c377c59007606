"""The diagnosis against worlds of other code: other kinematics, other forms of every departure."""

import json
import os
from pathlib import Path

import pytest
from worlds import named, seen, true_effects, world

import robolaser
from robolaser.diagnosis import examine
from robolaser.diagnosis.result_json import diagnosis_json

BLIND = Path(os.environ.get("ROBOLASER_DATA", "no-data")) / "blind-dev"


@pytest.mark.parametrize(("robot", "seed"), [("ur5", 107), ("xarm7", 114)], ids=["alone", "beside gross errors"])
def test_one_departure_is_named_with_its_place_first_and_alone(robot: str, seed: int) -> None:
    diagnosis = seen(robot, "single", seed)
    assert diagnosis.verdict == "explained"
    assert named(diagnosis) == true_effects(robot, "single", seed)
    assert diagnosis.where[0].site == diagnosis.findings[0].candidate_effect.where


def test_where_nothing_departs_nothing_is_found() -> None:
    diagnosis = seen("xarm7", "none", 101)
    assert diagnosis.verdict == "no_gap"
    assert not diagnosis.findings
    assert not diagnosis.where


def test_a_cause_that_the_library_lacks_is_said_to_be_unknown_or_truly_replaced() -> None:
    ((effect, where),) = true_effects("ur5", "single", 107)
    diagnosis = seen("ur5", "single", 107, without=(effect,))
    harmless = diagnosis.gap.after_m <= 1.1 * diagnosis.gap.noise_floor_m
    assert diagnosis.verdict == "unexplained" or harmless
    assert harmless or all(found.probability < 0.9 for found in diagnosis.findings)
    assert harmless or diagnosis.where[0].site == where


def test_the_gap_shrinks_to_the_noise_on_poses_held_out() -> None:
    gap = seen("ur5", "single", 107).gap
    assert gap.calibrated_m > 1.2 * gap.noise_floor_m
    assert gap.after_m < 1.08 * gap.noise_floor_m
    assert gap.after_ci95_m[0] < gap.after_m < gap.after_ci95_m[1]


def test_the_floor_is_what_the_noise_alone_gives() -> None:
    truth = world("ur5", "single", 107).truth["noise_floor_mm"]
    assert seen("ur5", "single", 107).gap.noise_floor_m * 1e3 == pytest.approx(truth, rel=0.05)


@pytest.mark.skipif(not BLIND.exists(), reason="ROBOLASER_DATA names no folder with the published worlds")
def test_every_published_world_is_read_right() -> None:
    truth = json.loads((BLIND / "truth.json").read_text())
    wrong = {}
    for name, told in truth.items():
        said = diagnosis_json(examine(robolaser.load(BLIND / name), seed=0))["effects"]
        want = {tuple(effect) for effect in told["effects"]}
        got = {(found["effect"], found["where"]) for found in said}
        classes = got | {tuple(rival) for found in said for rival in found["indistinguishable_from"]}
        confusable = any(each["rivals"] for each in told["each"])
        if not (got == want or (confusable and want <= classes and len(got) == len(want))):
            wrong[name] = (want, got)
    assert not wrong
