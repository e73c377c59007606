"""A parameter that the data set holds at a wrong value is a suspect, beside every effect of the library."""

from dataclasses import replace
from functools import cache

import numpy as np
import pytest
from cells import on_flange_poses

import robolaser
from robolaser.data.dataset import Dataset
from robolaser.data.stated_noise import Noise
from robolaser.diagnosis import examine
from robolaser.diagnosis.held_values import held_values
from robolaser.parameters import Parameter
from robolaser.results.calibration import CalibrationResult
from robolaser.results.diagnosis import DiagnosisResult
from robolaser.robot.by_name import find_robot
from robolaser.simulation import simulate

FOCAL = ("fx", "fy")
FEW = ["radial_distortion", "target_scale", "joint_offset"]
INTRINSICS = ("fx", "fy", "cx", "cy", "k1", "k2", "p1", "p2", "k3")


def seen(effects: dict[str, float] | None = None) -> Dataset:
    return simulate(
        find_robot("ur5e"), kind="camera", poses=25, noise=Noise(pixel_px=0.15, joint_rad=1e-5),
        effects=effects or {}, seed=3,
    ).dataset  # fmt: skip


@cache
def known() -> CalibrationResult:
    """What the same camera is found to be on an arm without errors."""
    return robolaser.calibrate(seen(), seed=0)


def held(dataset: Dataset, factors: dict[str, float], *, room: float = 0.0) -> Dataset:
    """With parameters at what they are known to be, times a factor."""
    parameters = dict(dataset.parameters)
    for name, factor in factors.items():
        value = known().value(name) * factor
        parameters[name] = Parameter(name, "px" if name[0] in "fc" else "", value, value - room, value + room)
    return replace(dataset, parameters=parameters)


@cache
def with_a_wrong_focal_length(room: float) -> DiagnosisResult:
    made = held(seen(), dict.fromkeys(FOCAL, 1.02), room=room)
    return robolaser.diagnose(made, effects=None if room else FEW, seed=0)


@pytest.mark.parametrize("room", [0.0, 2.0])
def test_a_wrong_focal_length_is_named_whether_fixed_or_bounded_narrowly(room: float) -> None:
    why = with_a_wrong_focal_length(room)
    first = why.effects[0]
    assert (why.verdict, first.effect, first.where) == ("explained", "held_parameter", "camera")
    assert why.classes[0]["class"] == "camera"
    assert first.parameters["fx"].value == pytest.approx(known().value("fx"), abs=4.0 * first.parameters["fx"].std)
    assert why.where[0].site == "camera"
    assert why.gap_mm.after < 1.1 * why.gap_mm.noise_floor < why.gap_mm.calibrated


def test_it_is_a_kind_and_shares_its_class_with_the_effects_of_that_class() -> None:
    dataset = held(seen({"focus_breathing": 0.03}), {"k1": 0.5})
    why = robolaser.diagnose(dataset, effects=["focus_breathing", "joint_offset"], seed=0)
    found = ["held_parameter", "focus_breathing"]
    assert [one.effect for one in why.effects] == [one.effect for one in why.kinds] == found
    (camera,) = why.classes
    assert [one.effect for one in camera.members] == found
    assert camera.gap_mm_without == why.gap_mm.calibrated
    assert camera.gap_mm_with == why.gap_mm.after


def test_further_poses_do_not_make_a_held_parameter_right() -> None:
    made = held(seen(), dict.fromkeys(FOCAL, 1.02))
    last = np.arange(len(made.poses)) >= len(made.poses) - 3
    grown = robolaser.diagnose(made.of_poses(~last), effects=FEW, seed=0).with_poses(made.of_poses(last))
    fresh = with_a_wrong_focal_length(0.0)
    assert (grown.verdict, grown.effects[0].effect) == (fresh.verdict, fresh.effects[0].effect)
    assert grown.effects[0].parameters["fx"].value == pytest.approx(fresh.effects[0].parameters["fx"].value, rel=1e-6)
    assert grown.with_poses(made).diagnosis is grown.diagnosis


def test_intrinsics_of_half_the_resolution_are_named() -> None:
    made = held(seen(), dict.fromkeys(("fx", "fy", "cx", "cy"), 0.5))
    why = robolaser.diagnose(on_flange_poses(made), effects=["target_scale"], seed=0)
    assert why.effects[0].effect == "held_parameter"
    assert why.effects[0].probability > 0.9
    assert set(why.effects[0].parameters) == {"fx", "fy", "cx", "cy"}


@pytest.mark.parametrize("effects", [{}, {"target_scale": 0.004}], ids=str)
def test_parameters_that_are_held_rightly_are_never_named(effects: dict[str, float]) -> None:
    made = held(seen(effects), dict.fromkeys(INTRINSICS, 1.0))
    why = robolaser.diagnose(made, effects=FEW if effects else None, seed=0)
    assert [one.effect for one in why.effects] == list(effects)


def test_another_cause_beside_a_wrong_focal_length_is_still_found() -> None:
    made = held(seen({"joint_offset:elbow_joint": 3e-3}), dict.fromkeys(FOCAL, 0.97))
    why = robolaser.diagnose(made, effects=["joint_offset", "target_scale"], seed=0)
    assert {(one.effect, one.where) for one in why.effects} >= {
        ("held_parameter", "camera"),
        ("joint_offset", "elbow_joint"),
    }
    assert why.verdict == "explained"


@pytest.mark.parametrize(("wrong", "factor", "named"), [(FOCAL, 1.002, False), ((*FOCAL, "cx", "cy"), 0.5, True)])
def test_a_held_parameter_is_named_beside_an_unknown_cause_only_if_it_explains_far_more(
    wrong: tuple[str, ...], factor: float, named: bool
) -> None:
    made = held(seen({"joint_offset:elbow_joint": 3e-3}), dict.fromkeys(wrong, factor))
    why = robolaser.diagnose(made, effects=["tangential_distortion"], seed=0)
    assert why.verdict == "unexplained"
    assert ("held_parameter" in [one.effect for one in why.effects]) == named


def test_a_lens_that_is_held_straight_is_named_beside_a_larger_error_of_the_arm() -> None:
    made = held(seen({"joint_offset:elbow_joint": 3e-3}), dict.fromkeys(("k1", "k2", "p1", "p2", "k3"), 0.0))
    why = robolaser.diagnose(made, effects=[*FEW, "focus_breathing"], seed=0)
    assert {(one.effect, one.where) for one in why.effects} == {
        ("held_parameter", "camera"),
        ("joint_offset", "elbow_joint"),
    }
    assert why.verdict == "explained"


def test_a_tool_held_at_a_wrong_place_is_a_rival_of_one_effect_of_several() -> None:
    noise, effects = Noise(joint_rad=2e-5), {"joint_offset:elbow_joint": 2e-3}
    sound, made = (
        simulate(find_robot("ur5e"), kind="socket", poses=30, noise=noise, effects=some, seed=5).dataset
        for some in ({}, effects)
    )
    z = robolaser.calibrate(sound).value("tool.ball.z") + 5e-4
    item = Parameter("tool.ball.z", "m", z, z, z)
    wrong = replace(made, parameters={**made.parameters, item.name: item})
    why = robolaser.diagnose(wrong, effects=["joint_offset", "link_geometry"], seed=0)
    by_name = {(one.effect, one.where): one for one in why.effects}
    assert by_name.keys() == {("held_parameter", "tool"), ("joint_offset", "elbow_joint")}
    tool = by_name["held_parameter", "tool"]
    assert tool.probability < 0.9
    assert tool.indistinguishable_from == [["link_geometry", "wrist_3_joint"]]


@pytest.mark.parametrize(("off_m", "effects"), [(0.01, {}), (0.0, {"link_geometry:shoulder_pan_joint.x": 5e-4})])
def test_a_base_held_at_a_wrong_place_and_a_first_joint_at_a_wrong_one_are_rivals(
    off_m: float, effects: dict[str, float]
) -> None:
    noise = Noise(point_m=3e-5)
    sound, made = (
        simulate(find_robot("ur5"), kind="point", poses=40, noise=noise, effects=some, seed=3).dataset
        for some in ({}, effects)
    )
    x = robolaser.calibrate(sound).value("base.x") + off_m
    why = robolaser.diagnose(replace(made, parameters={"base.x": Parameter("base.x", "m", x, x, x)}), seed=0)
    (found,) = why.effects
    assert (why.verdict, found.effect, found.where) == ("explained", "held_parameter", "base")
    assert found.probability < 0.9
    assert found.indistinguishable_from == [["link_geometry", "shoulder_pan_joint"]]


def test_optics_of_a_scanner_that_are_held_at_those_of_another_camera_are_named() -> None:
    """A scanner without a board has no closed form for them."""
    noise = Noise(pixel_px=0.1, joint_rad=1e-5)
    seen = simulate(find_robot("ur5e"), poses=20, points=8, noise=noise, seed=5).dataset
    known = robolaser.calibrate(seen, seed=0)
    other = {
        name: replace(item, nominal=2.0 * item.nominal, lower=1.9 * item.nominal, upper=2.2 * item.nominal)
        for name, item in seen.parameters.items()
        if name in ("s_u", "s_v")
    }
    why = robolaser.diagnose(replace(seen, parameters={**seen.parameters, **other}), effects=FEW, seed=0)
    first = why.effects[0]
    assert (why.verdict, first.effect, first.where) == ("explained", "held_parameter", "camera")
    for name in other:
        free = first.parameters[name]
        assert free.value == pytest.approx(known.value(name), abs=4.0 * free.std)


def profiles(effects: dict[str, float] | None = None, **off_m: float) -> Dataset:
    """Balls whose stated radii are off by so much."""
    noise = Noise(point_m=5e-5, joint_rad=1e-5)
    seen = simulate(find_robot("ur5e"), kind="profile", poses=24, noise=noise, effects=effects or {}, seed=1).dataset
    return replace(seen, radius_m={ball: r + off_m.get(f"of_{ball}", 0.0) for ball, r in seen.radius_m.items()})


def test_the_ball_whose_radius_is_stated_wrongly_is_named_with_its_radius() -> None:
    wrong = profiles(of_1=2e-4)
    why = robolaser.diagnose(wrong, effects=FEW, seed=0)
    first = why.effects[0]
    assert (why.verdict, first.effect, first.where) == ("explained", "held_parameter", "target")
    assert set(first.parameters) == {"ball.1.radius"}
    radius = first.parameters["ball.1.radius"]
    assert radius.value == pytest.approx(wrong.radius_m["1"] - 2e-4, abs=4.0 * radius.std)
    assert why.gap_mm.after < 1.1 * why.gap_mm.noise_floor < why.gap_mm.calibrated


def test_a_ball_that_is_held_at_a_wrong_place_is_to_be_corrected_where_it_is_held() -> None:
    made = profiles()
    x = robolaser.calibrate(made, seed=0).value("ball.1.x") + 2e-3
    wrong = replace(made, parameters={**made.parameters, "ball.1.x": Parameter("ball.1.x", "m", x, x, x)})
    why = robolaser.diagnose(wrong, effects=["target_scale"], seed=0)
    assert set(why.effects[0].parameters) == {"ball.1.x"}
    assert "Correct it under [parameters]." in why.sentence


def test_radii_that_are_stated_rightly_are_never_named() -> None:
    why = robolaser.diagnose(profiles({"joint_offset:elbow_joint": 2e-3}), effects=FEW, seed=0)
    assert [(one.effect, one.where) for one in why.effects] == [("joint_offset", "elbow_joint")]


def test_a_corrected_radius_carries_over_to_other_data_with_the_wrong_one() -> None:
    whole = profiles(of_0=3e-4, of_1=3e-4, of_2=3e-4)
    first, other = (whole.of_poses(np.arange(24) % 2 == half) for half in (0, 1))
    (validation,) = robolaser.diagnose(first, effects=FEW, seed=0, validate=[other]).validation
    assert validation["after_mm"] < 1.1 * validation["noise_floor_mm"]


def test_what_is_saved_has_the_freed_values() -> None:
    why = with_a_wrong_focal_length(0.0)
    assert why.model.value("fx") == pytest.approx(why.effects[0].parameters["fx"].value)


def test_no_file_holds_what_a_closed_form_found() -> None:
    """A scanner without a first guess: bounds around its start are nobody's."""
    noise = Noise(pixel_px=0.15)
    made = simulate(find_robot("ur5e"), kind="stripe+camera", poses=10, noise=noise, seed=3).dataset
    found = examine(replace(made, parameters={}), effects=[], seed=0)
    assert found.model.blocks.given
    assert held_values(replace(found, calibrated_x=found.model.parameters.upper)) == []
