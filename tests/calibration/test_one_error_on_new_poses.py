"""A calibration weighed by noise and a diagnosis of the same data print one error on new poses."""

from dataclasses import replace
from functools import cache

import numpy as np
import pytest
from asked import simulate_as_asked
from several import two_trackers

import robolaser
from robolaser.data.dataset import Dataset
from robolaser.data.stated_noise import Noise
from robolaser.diagnosis import examine
from robolaser.diagnosis.result import Diagnosis
from robolaser.robot.by_name import find_robot
from robolaser.simulation import CellOptions, simulate

NOISE = Noise(pixel_px=0.1, target_m=3e-5, point_m=2e-5, joint_rad=1e-4)
KINDS = ("stripe", "point", "socket", "camera", "pose", "profile", "two trackers", "three sessions", "gross errors")


@cache
def data(kind: str) -> Dataset:
    if kind == "two trackers":
        return two_trackers()
    if kind == "three sessions":
        return simulate(
            find_robot("scorbot_er7"), kind="point", poses=12, noise=NOISE, options=CellOptions(sessions=3), seed=4
        ).dataset
    if kind == "gross errors":
        effects = {"outliers": 0.02}
        return simulate(find_robot("scorbot_er7"), poses=24, noise=NOISE, effects=effects, seed=4).dataset
    repeats = {"repeats": 2, "points": 12} if kind in ("stripe", "camera") else {}
    return simulate_as_asked(
        find_robot("scorbot_er7"), kind=kind, poses=15, noise=NOISE, stated=Noise(), seed=4, **repeats
    ).dataset


@cache
def diagnosed(kind: str) -> Diagnosis:
    return examine(data(kind), [], seed=3)


@pytest.mark.parametrize("kind", KINDS)
def test_the_calibrated_gap_is_the_error_on_new_poses_of_a_calibration_by_noise(kind: str) -> None:
    found = robolaser.calibrate(data(kind), robolaser.Plan(weights="noise", seed=3))
    diagnosis = diagnosed(kind)
    assert diagnosis.gap.calibrated_m == pytest.approx(found.held_out_rms_m, rel=1e-12)
    np.testing.assert_allclose(diagnosis.calibrated_x, found.x)


@pytest.mark.parametrize("kind", KINDS[:-1])
def test_where_nothing_is_found_what_is_left_is_the_same_error(kind: str) -> None:
    diagnosis = diagnosed(kind)
    assert not diagnosis.findings
    later = 1e-3  # a row that only the diagnosis judges to be a gross error
    assert diagnosis.gap.after_m == pytest.approx(diagnosis.gap.calibrated_m, rel=later)


def test_without_effects_a_diagnosis_is_the_calibration_though_whole_poses_scatter():
    noise = Noise(point_m=2e-5, joint_rad=3e-4)
    shaken = simulate(find_robot("ur5"), kind="point", poses=24, noise=noise, seed=2).dataset
    stated = replace(shaken, noise=Noise(point_m=2e-5))
    found = examine(stated, [], seed=3)
    plain = robolaser.calibrate(stated, robolaser.Plan(weights="noise", seed=3)).calibration
    assert found.noise["joint"].value > 0.0
    assert found.x == pytest.approx(plain.x, rel=1e-12)
    assert found.gap.after_m == found.gap.calibrated_m == plain.held_out_rms_m
