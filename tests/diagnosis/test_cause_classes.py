"""Classes of causes: certain where single effects are not."""

from dataclasses import replace
from types import SimpleNamespace

import pytest
from worlds import kinds

from robolaser.data.dataset import Dataset
from robolaser.data.stated_noise import Noise
from robolaser.diagnosis import Diagnosis, examine
from robolaser.diagnosis import cause_classes as cause_classes_module
from robolaser.diagnosis.cause_classes import (
    cause_kinds,
    class_of,
    credible_set,
    departs,
    member_probabilities,
    unknown_at,
)
from robolaser.diagnosis.evidence import EffectEvidence
from robolaser.diagnosis.localization import Localization
from robolaser.diagnosis.pruning import exchanged
from robolaser.diagnosis.result import CauseClass
from robolaser.model.effects import EFFECTS
from robolaser.model.effects.effect import CandidateEffect
from robolaser.robot.by_name import find_robot
from robolaser.simulation import simulate

BY_NAME = {effect.name: effect for effect in EFFECTS}


def candidate(name: str, where: str) -> CandidateEffect:
    return CandidateEffect(BY_NAME[name], where)


ELBOW, WRIST = candidate("joint_offset", "joint_3"), candidate("joint_offset", "joint_4")
GEAR = candidate("backlash", "joint_3")


def weighed(weights: dict[CandidateEffect | None, float], credibility: float = 1.0) -> EffectEvidence:
    first = next(one for one in weights if one is not None)
    return EffectEvidence(first, 100.0, weights[first], credibility, weights, {}, ())


def test_a_kind_is_told_where_its_effects_are_and_not_where_these_are_too_improbable():
    refits = SimpleNamespace(without=lambda *_: None, of=lambda _: None)
    held_out = SimpleNamespace(gap_without=lambda _: 1.0)
    evidence = [weighed({ELBOW: 0.999, None: 0.001}), weighed({GEAR: 0.001, None: 0.999})]
    assert [one.effect for one in cause_kinds(refits, None, evidence, held_out)] == ["joint_offset"]


def test_every_effect_of_the_package_belongs_to_a_class():
    assert all(effect.cause for effect in EFFECTS)


def test_an_effect_without_a_class_is_one_of_its_own():
    class Fan(BY_NAME["backlash"]):
        name = "fan"
        cause = ""

    assert class_of(CandidateEffect(Fan, "joint_1")) == "fan"


def test_a_credible_set_has_the_fewest_candidates_that_hold_95_percent():
    assert credible_set(weighed({ELBOW: 0.6, WRIST: 0.37, GEAR: 0.03, None: 0.0})) == (ELBOW, WRIST)
    assert credible_set(weighed({ELBOW: 0.97, WRIST: 0.03, None: 0.0})) == (ELBOW,)


def test_a_set_that_none_or_a_cause_nobody_modelled_may_explain_as_well_is_not_credible():
    assert credible_set(weighed({ELBOW: 0.6, None: 0.4})) == ()
    assert credible_set(weighed({ELBOW: 0.6, WRIST: 0.4}, credibility=0.9)) == ()


def test_candidates_share_the_probability_of_what_they_could_each_explain():
    found = member_probabilities([weighed({ELBOW: 0.6, WRIST: 0.4, None: 0.0}, credibility=0.5)])
    assert found == pytest.approx({ELBOW: 0.3, WRIST: 0.2})


def test_a_candidate_of_two_places_is_as_probable_as_either():
    found = member_probabilities([weighed({ELBOW: 0.5, WRIST: 0.5}), weighed({GEAR: 0.8, ELBOW: 0.2})])
    assert found[ELBOW] == pytest.approx(1 - 0.5 * 0.8)


def test_what_an_effect_leaves_in_its_own_place_is_its_form_as_far_as_the_effect_is_credible():
    evidence = [weighed({ELBOW: 1.0, None: 0.0}, credibility=0.6)]
    assert departs("joint_3", evidence) == pytest.approx(0.4)
    assert departs("joint_4", evidence) == 1.0


def test_the_unknown_is_where_most_of_the_gap_is_listed():
    classes = CauseClass("transmission", 0.3, 2e-4, 1e-4), CauseClass("unknown", 0.7, None, 1e-4)
    lies = Localization("joint_3", "angle of joint_3", 0.9, 50.0, 1e-9)
    assert [one.site for one in unknown_at(classes, [lies])] == ["", "joint_3"]
    assert [one.site for one in unknown_at(classes, [])] == ["", ""]


def test_a_gap_of_probably_unknown_cause_is_not_explained(monkeypatch):
    made = simulate(find_robot("ur5e"), kind="point", poses=60, noise=Noise(point_m=1e-4), seed=2,
                    effects={"encoder_eccentricity:elbow_joint": 5e-4}).dataset  # fmt: skip
    monkeypatch.setattr(cause_classes_module, "_probability", lambda *_: 0.0)
    monkeypatch.setattr(cause_classes_module, "at_least_one", lambda _: 0.2)
    found = examine(made, [BY_NAME["encoder_eccentricity"]], seed=0)
    assert found.findings
    assert found.verdict == "unexplained"
    assert found.where[0].site == "elbow_joint"
    assert found.sentence.startswith("The gap is real, but its cause is probably not an effect of the library. The err")


@pytest.mark.parametrize(
    ("weight", "gap", "is_plausible", "takes"),
    [(0.9, 1.0, True, True), (0.9, 1.1, True, False), (0.4, 0.9, True, False), (0.7, 1.05, False, True)],
)
def test_what_is_probable_in_a_place_takes_it_where_new_poses_are_predicted_as_well(weight, gap, is_plausible, takes):
    final = SimpleNamespace(is_plausible=lambda one: is_plausible)
    evidence = replace(
        weighed({ELBOW: 1.0 - weight, WRIST: weight, None: 0.0}), alternatives=((WRIST, "with the wrist"),)
    )
    found = exchanged(final, evidence, SimpleNamespace(misfit=lambda fit: 1.0 if fit is final else gap))
    assert found == ("with the wrist" if takes else None)


def parallel_joints() -> Dataset:
    """A few poses in which two joints with parallel axes hardly move: their offsets look alike."""
    noise = Noise(pixel_px=0.1, target_m=3e-5)
    return simulate(
        find_robot("scorbot_er7"), poses=25, points=6, noise=noise, effects={"joint_offset:joint_3": 0.01}, seed=5
    ).dataset


@pytest.fixture(scope="module")
def diagnosis() -> Diagnosis:
    others = kinds("link_geometry", "encoder_scale", "encoder_eccentricity", "joint_coupling", "joint_compliance")
    return examine(parallel_joints(), kinds("joint_offset") + others, seed=0)


def test_a_class_is_at_least_as_probable_as_each_of_its_members(diagnosis):
    for one in diagnosis.classes:
        assert one.probability >= max((p for _, p in one.members), default=0.0) - 1e-9


def test_the_class_of_a_large_offset_is_certain(diagnosis):
    first = diagnosis.classes[0]
    assert first.name == "arm_geometry"
    assert first.probability > 0.99
    assert first.gap_without_m > 2 * first.gap_with_m


def test_without_a_gap_there_is_no_class():
    assert (
        examine(simulate(find_robot("ur5"), poses=25, points=6, seed=1).dataset, kinds("joint_offset"), seed=0).classes
        == ()
    )


def test_a_kind_of_effect_is_at_least_as_probable_as_each_of_its_places(diagnosis):
    assert diagnosis.kinds
    for kind in diagnosis.kinds:
        own = [one for one in diagnosis.findings if one.candidate_effect.effect.name == kind.effect]
        assert {one.candidate_effect.where for one in own} <= set(kind.where)
        assert all(kind.probability >= one.probability - 1e-9 for one in own)
        assert kind.gap_without_m >= diagnosis.gap.after_m * 0.98
