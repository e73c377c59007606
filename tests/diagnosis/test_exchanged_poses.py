"""Rows that lie at each other's poses are told from gross errors, and used where they belong."""

import json
from dataclasses import replace
from functools import cache
from importlib.resources import files

import jsonschema
import numpy as np
import pytest
from cells import on_flange_poses

import robolaser
from robolaser.data.dataset import Dataset
from robolaser.data.joining import join_sessions
from robolaser.data.stated_noise import Noise
from robolaser.report.diagnosis.advice import to_do
from robolaser.results.diagnosis import DiagnosisResult
from robolaser.robot.by_name import find_robot
from robolaser.simulation import CellOptions, simulate

NOISE = {"camera": Noise(pixel_px=0.15), "point": Noise(point_m=5e-5), "stripe": Noise(pixel_px=0.2)}
FEW = ["joint_offset", "backlash", "hand_eye_drift"]
ARM = find_robot("scorbot_er7")  # of few joints: each is a reading that may be wrong instead
SCHEMA = json.loads(files("robolaser.schemas").joinpath("diagnosis.schema.json").read_text())
POINTS = {"camera": 12, "point": 3, "stripe": 6}


@cache
def measured(kind: str, **offset: float) -> Dataset:
    effects = {f"joint_offset:{joint}": size for joint, size in offset.items()}
    made = simulate(ARM, kind=kind, poses=20, points=POINTS[kind], noise=NOISE[kind], effects=effects, seed=3).dataset
    return on_flange_poses(made) if kind == "camera" else made


def moved(dataset: Dataset, to: dict[int, int]) -> Dataset:
    number = np.arange(len(dataset.poses))
    number[list(to)] = list(to.values())
    return replace(dataset, points=replace(dataset.points, pose=number[dataset.points.pose]))


EXCHANGED = {"camera": {7: 12, 12: 7}, "point": {3: 14, 14: 18, 18: 3}, "stripe": {3: 14, 14: 18, 18: 3}}


@cache
def why_of(kind: str) -> DiagnosisResult:
    """With the whole library where rows are few."""
    dataset = moved(measured(kind), EXCHANGED[kind])
    return robolaser.diagnose(dataset, effects=None if kind == "point" else FEW, seed=0)


@pytest.mark.parametrize("kind", ["camera", "point"])
def test_exchanged_poses_are_named_and_no_row_is_lost(kind: str) -> None:
    why, to = why_of(kind), EXCHANGED[kind]
    (found,) = why.effects
    assert (found.effect, found.where, found.parameters["poses"].value) == ("mispaired", "image", len(to))
    assert all(str(pose) in why.sentence for pose in to)
    assert (why.verdict, why.gross_errors) == ("no_gap", [])
    jsonschema.validate(why.to_dict(), SCHEMA)


@pytest.mark.parametrize("kind", ["camera", "point"])
def test_the_corrected_model_has_the_errors_of_rows_at_the_poses_where_they_belong(kind: str) -> None:
    corrected = why_of(kind).model
    assert corrected.rms_m < 1.2 * corrected.held_out_rms_m
    assert any("are exchanged" in warning or "belong to pose" in warning for warning in corrected.warnings)


@pytest.mark.parametrize("kind", ["camera", "point"])
def test_a_calibration_warns_of_exchanged_poses(kind: str) -> None:
    first, second = list(EXCHANGED[kind])[:2]
    rows = moved(measured(kind), {first: second, second: first})
    warning, *_ = robolaser.calibrate(rows, seed=0).warnings
    assert f"poses {first} and {second} are exchanged: with that corrected, the error is" in warning
    assert not robolaser.calibrate(measured(kind), seed=0).warnings


def test_exchanged_poses_are_named_across_sessions_too() -> None:
    options = CellOptions(sessions=2)
    made = simulate(ARM, kind="point", poses=12, points=3, noise=NOISE["point"], options=options, seed=3).dataset
    why = robolaser.diagnose(moved(on_flange_poses(made), {5: 19, 19: 5}), effects=FEW, seed=0)
    assert [one.effect for one in why.effects] == ["mispaired"]
    assert why.verdict == "no_gap"


def test_exchanged_poses_are_named_though_each_has_a_copy_that_is_right() -> None:
    once = simulate(ARM, kind="point", poses=18, points=3, noise=NOISE["point"], seed=2).dataset
    twice = on_flange_poses(join_sessions({"one": once, "two": once}, name="twice"))
    why = robolaser.diagnose(moved(twice, {5: 26, 26: 5}), effects=FEW, seed=0)
    assert [one.effect for one in why.effects] == ["mispaired"]
    assert (why.verdict, why.gross_errors) == ("no_gap", [])


def test_a_cause_beside_exchanged_images_is_still_named() -> None:
    made = measured("stripe", joint_3=3e-3)
    why = robolaser.diagnose(moved(made, EXCHANGED["stripe"]), effects=FEW, seed=0)
    assert {(one.effect, one.where) for one in why.effects} == {("mispaired", "image"), ("joint_offset", "joint_3")}


def test_rows_that_fit_nowhere_stay_gross_errors() -> None:
    made = measured("camera")
    pixel = made.points["pixel"].copy()
    pixel[np.isin(made.points.pose, (7, 12))] += 40.0
    why = robolaser.diagnose(replace(made, points=replace(made.points, pixel=pixel)), effects=FEW, seed=0)
    assert [one.effect for one in why.effects] == ["outliers"]


def test_the_first_thing_to_do_is_to_correct_the_data_set() -> None:
    said = to_do(why_of("point").diagnosis)
    assert "Correct the data set" in said[0]
    assert not any("Nothing needs repair" in one for one in said)
