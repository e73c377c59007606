"""What counts as right, and what the shares of it are worth."""

import pytest

from robolaser.trials.score import compile_score, outcome

GAP = {"nominal": 9.0, "calibrated": 1.0, "after": 0.1, "noise_floor": 0.1, "after_ci95": [0.09, 0.11]}


CLASSES = {"joint_offset": "arm_geometry", "backlash": "transmission", "outliers": "outliers"}


def true(effect="joint_offset", where="joint_2", misfit=900.0, rivals=(), size=1e-3, sites=None, also_right=()):
    return {
        "effect": effect, "where": where, "misfit": misfit, "rivals": [list(rival) for rival in rivals],
        "values": {"offset": size}, "sites": sites or [where], "classes": [CLASSES.get(effect, "transmission")],
        "also_right": [list(place) for place in also_right],
    }  # fmt: skip


def found(effect="joint_offset", where="joint_2", probability=0.99, alike=(), value=1e-3, std=1e-5):
    return {
        "effect": effect,
        "where": where,
        "probability": probability,
        "parameters": {"offset": {"value": value, "std": std, "unit": "rad"}},
        "indistinguishable_from": [list(other) for other in alike],
    }


def said(*effects, verdict="explained", where="joint_2", classes=None, **gap):
    places = [] if verdict == "no_gap" else [{"site": where, "share": 1.0}]
    stated = {} if classes is None else {"classes": [{"class": c, "probability": p} for c, p in classes.items()]}
    return {"verdict": verdict, "gap_mm": {**GAP, **gap}, "where": places, "effects": list(effects), **stated}


def seen(each, diagnosis, background=(), kind="single"):
    return outcome({"kind": kind, "each": each, "background": background}, diagnosis)


OUTLIERS = true("outliers", "image", 9e4)
BACKLASH = true("backlash", "joint_3")


@pytest.mark.parametrize(
    ("each", "diagnosis", "group", "right"),
    [
        ([], said(verdict="no_gap"), "none", True),
        ([], said(found()), "none", False),
        ([], said(verdict="unexplained"), "none", False),
        ([OUTLIERS], said(found("outliers", "image"), verdict="no_gap"), "outliers", True),
        ([OUTLIERS], said(found("outliers", "image"), found()), "outliers", False),
        ([true()], said(found()), "one", True),
        ([true(), OUTLIERS], said(found("outliers", "image"), found()), "one", True),
        ([true()], said(found(where="joint_3")), "one", False),
        ([true()], said(found(), found("laser_roll", "laser")), "one", False),
        ([true()], said(found("laser_roll", "laser", alike=[("joint_offset", "joint_2")])), "one", False),
        ([true()], said(verdict="no_gap"), "one", False),
        ([true(misfit=50.0)], said(verdict="no_gap"), "faint", True),
        ([true(misfit=50.0)], said(found("laser_roll", "laser")), "faint", False),
        (
            [true(rivals=[("laser_roll", "laser")])],
            said(found("laser_roll", "laser", alike=[("joint_offset", "joint_2")])),
            "confusable",
            True,
        ),
        ([true(rivals=[("laser_roll", "laser")])], said(found("laser_roll", "laser")), "confusable", False),
        ([true(), BACKLASH], said(found("backlash", "joint_3"), found()), "several", True),
        ([true(), BACKLASH], said(found()), "several", False),
        ([true(), BACKLASH], said(found(), found(where="joint_3")), "several", False),
        (
            [true(), BACKLASH],
            said(found(), found("joint_offset", "joint_3", alike=[("backlash", "joint_3")])),
            "several",
            True,
        ),
        ([true("hose", "joint_4")], said(verdict="unexplained", where="joint_4"), "unknown", True),
        ([true("hose", "joint_4")], said(found(probability=0.8), verdict="explained", after=0.105), "unknown", True),
        ([true("hose", "joint_4")], said(found(), verdict="explained", after=0.105), "unknown", False),
        ([true("hose", "joint_4")], said(found(), verdict="explained", after=0.2), "unknown", False),
        ([true("hose", "joint_4")], said(found(probability=0.95), verdict="unexplained"), "unknown", False),
        ([true("hose", "joint_4")], said(found(probability=0.5), verdict="unexplained"), "unknown", True),
    ],
)
def test_right_is_what_may_be_asked_for(each, diagnosis, group, right):
    result = seen(each, diagnosis)
    assert (result.group, result.right) == (group, right)


SMALL = [["joint_offset", "joint_1"], ["radial_distortion", "camera"]]


@pytest.mark.parametrize(
    ("each", "classes", "right"),
    [
        ([true()], {"arm_geometry": 0.99}, True),
        ([true()], {"arm_geometry": 0.99, "laser": 0.6}, True),
        ([true()], {"arm_geometry": 0.99, "laser": 0.95}, False),
        ([true()], {"arm_geometry": 0.4}, False),
        ([true()], None, None),
        ([true(), BACKLASH], {"arm_geometry": 0.99}, False),
        ([true(), BACKLASH], {"arm_geometry": 0.99, "transmission": 0.7}, True),
        ([true("hose", "joint_4")], {"unknown": 0.9}, True),
        ([true("hose", "joint_4")], {"transmission": 0.9}, True),
        ([true("hose", "joint_4")], {"mount": 0.9}, False),
        ([true(misfit=50.0)], {"laser": 0.99}, None),
        ([], {}, True),
        ([], {"elasticity": 0.95}, False),
    ],
)
def test_a_class_is_right_if_the_true_ones_are_likely_and_no_wrong_one_is_sure(each, classes, right):
    assert seen(each, said(classes=classes)).class_right == right


def test_small_errors_that_are_there_may_be_named_and_need_not_be():
    small = found("joint_offset", "joint_1", probability=0.97)
    for diagnosis in (said(found()), said(small, found())):
        result = seen([true()], diagnosis, SMALL)
        assert result.right
        assert not result.sure_and_wrong
    assert not seen([true()], said(small), SMALL).right
    assert seen([true()], said(found(), found("laser_roll", "laser")), SMALL).sure_and_wrong


def test_what_small_errors_leave_may_be_left_unexplained():
    left = said(found(), verdict="unexplained", classes={"arm_geometry": 0.99, "unknown": 0.99}, where="joint_5")
    result = seen([true()], left, SMALL)
    assert (result.verdict_right, result.class_right, result.site_first) == (True, True, None)


def test_a_name_that_is_as_good_as_the_true_one_is_no_false_one():
    form = true("hysteresis", "joint_2", also_right=[("joint_compliance", "joint_2")])
    assert seen([form], said(found("joint_compliance", "joint_2"), after=0.1)).right
    assert not seen([form], said(found("joint_compliance", "joint_3"), after=0.1)).right


@pytest.mark.parametrize(
    ("each", "verdict", "after", "right"),
    [
        ([], "no_gap", 0.1, True),
        ([], "explained", 0.1, False),
        ([true()], "explained", 0.1, True),
        ([true()], "unexplained", 0.1, False),
        ([true("hose", "joint_4")], "unexplained", 0.3, True),
        ([true("hose", "joint_4")], "explained", 0.3, False),
        ([true("hose", "joint_4")], "explained", 0.1, True),
        ([true(misfit=50.0)], "no_gap", 0.1, None),
    ],
)
def test_a_verdict_is_right_by_what_is_wrong(each, verdict, after, right):
    assert seen(each, said(verdict=verdict, after=after)).verdict_right == right


def test_an_unknown_effect_may_be_found_at_any_of_its_sites():
    hose = true("hose", "joint_4", sites=["joint_3", "joint_4", "joint_5"])
    assert seen([hose], said(verdict="unexplained", where="joint_5")).site_first
    assert not seen([hose], said(verdict="unexplained", where="joint_1")).site_first


def test_of_equal_numbers_twice_the_deviation_is_outside_the_interval():
    assert seen([true()], said(found(value=1.015e-3))).covered == (True,)
    assert seen([true()], said(found(value=1.025e-3))).covered == (False,)


def test_what_is_not_determined_and_what_is_no_amplitude_has_no_interval():
    drift = {**true("laser_drift", "laser"), "values": {"angle": 1e-3, "tau": 0.3}}
    numbers = {"angle": {"value": 1e-3, "std": 1e-5}, "tau": {"value": 0.9, "std": 1e-5}}
    assert seen([drift], said({**found("laser_drift", "laser"), "parameters": numbers})).covered == (True,)
    assert seen([true()], said(found(std=None))).covered == ()


@pytest.fixture
def scored():
    return compile_score(
        {
            "a": seen([], said(verdict="no_gap")),
            "b": seen([true()], said(found(probability=0.97))),
            "c": seen([true()], said(found("laser_roll", "laser", probability=0.6))),
            "d": seen([true(), BACKLASH], said(found("backlash", "joint_3"), found())),
            "e": seen([true("hose", "joint_4")], said(verdict="unexplained", where="joint_4")),
        }
    )


def test_every_stated_probability_falls_into_one_bin(scored):
    assert sum(part["of"] for part in scored["reliability"]) == 4
    assert sum(part["right"] for part in scored["reliability"]) == 3


def test_kinds_are_scored_apart():
    scored = compile_score(
        {
            "a": seen([], said(verdict="no_gap", classes={}), kind="none"),
            "b": seen([true()], said(found(), classes={"arm_geometry": 0.99}), kind="single"),
            "c": seen([true()], said(found("laser_roll", "laser"), classes={"laser": 0.99}), kind="single"),
        }
    )
    assert scored["kinds"]["none"]["by_name"]["share"] == 1.0
    single = scored["kinds"]["single"]
    assert (single["by_name"]["share"], single["by_class"]["share"], single["sure_and_wrong"]["share"]) == (0.5,) * 3
    assert sum(part["of"] for part in scored["reliability_of_classes"]) == 2
    assert sum(part["right"] for part in scored["reliability_of_classes"]) == 1
