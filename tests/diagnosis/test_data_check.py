"""A data set's check says what it allows and what is missing for the rest, and agrees with the diagnosis."""

import copy
import json
import time
from dataclasses import replace

import numpy as np
import pytest

from robolaser import EFFECTS, find_robot
from robolaser.cli import main
from robolaser.data.dataset import Dataset
from robolaser.data.writing import save
from robolaser.diagnosis.data_check import DataCheck, check_data
from robolaser.model.effects.requirements import NO_JOINTS, SensorLacks
from robolaser.simulation import simulate


@pytest.fixture(scope="module")
def dataset() -> Dataset:
    return simulate(find_robot("scorbot_er7"), poses=30, seed=2).dataset


def reasons(found: DataCheck) -> dict[str, str]:
    return {one.effect: one.reason for one in found.effects if one.reason}


def test_every_effect_is_testable_or_has_a_reason(dataset):
    found = check_data(dataset)
    assert [one.effect for one in found.effects] == [kind.name for kind in EFFECTS]
    assert all(bool(one.locations) != bool(one.reason) for one in found.effects)
    assert not found.hindrance
    assert found.inseparable == ()


def test_what_is_missing_names_the_effects_that_wait_for_it(dataset):
    found = check_data(replace(dataset, poses=replace(dataset.poses, time_s=None, qd=None)))
    of_time = next(names for remedy, names in found.missing.items() if "time_s" in remedy)
    assert {"backlash", "base_shift", "hand_eye_drift"} <= set(of_time)
    assert next(names for remedy, names in found.missing.items() if "qd_<joint>" in remedy) == ("latency",)
    assert "backlash" not in reasons(check_data(dataset))


def test_with_what_it_asks_for_the_effect_can_be_tested(dataset):
    moving = replace(dataset.poses, qd=np.full_like(dataset.poses.q, 0.1))
    assert "latency" not in reasons(check_data(replace(dataset, poses=moving)))


def test_what_no_sensor_of_the_kind_has_is_not_asked_for(dataset):
    tracker = simulate(find_robot("scorbot_er7"), kind="point", poses=30, seed=2).dataset
    found = check_data(tracker)
    beyond = {kind.name for kind in EFFECTS if isinstance(kind.missing(tracker), SensorLacks)}
    assert "laser_roll" in beyond
    assert beyond.isdisjoint(name for names in found.missing.values() for name in names)


def test_a_reason_is_the_one_that_the_diagnosis_gives(dataset):
    assert reasons(check_data(dataset)) == {
        kind.name: kind.missing(dataset) for kind in EFFECTS if kind.missing(dataset)
    }


def test_too_few_poses_allow_neither(dataset):
    found = check_data(dataset.of_poses(np.arange(30) < 1))
    assert "at least 2 are needed" in found.hindrance
    assert "fewer than 5 poses have points" in set(reasons(found).values())


def test_parameters_that_nothing_sees_apart_are_named():
    flat = simulate(find_robot("scorbot_er7"), kind="point", poses=20, points=1, seed=2).dataset
    still = replace(flat, poses=replace(flat.poses, q=flat.poses.q * np.array([1, 0, 0, 0, 0])))
    found = check_data(still)  # turned about one axis alone: the tool may be anywhere along it
    assert any("tool.point_1.z" in names or len(names) > 1 for names in found.inseparable)


def test_a_recording_without_points_is_told_the_next_command(dataset, tmp_path):
    raw = replace(
        dataset,
        points=dataset.points.take(slice(0, 0)),
        poses=replace(dataset.poses, image=tuple(f"images/{i}.png" for i in range(30))),
    )
    assert "robolaser extract" in check_data(raw).hindrance
    assert "fewer than" not in " ".join(reasons(check_data(raw)).values())
    bare = replace(raw, poses=replace(raw.poses, image=None))
    assert check_data(bare).hindrance.startswith("There are no points")


def test_the_command_says_it_in_text_and_as_json_within_seconds(dataset, tmp_path, capsys):
    save(dataset, tmp_path / "cell")
    began = time.process_time()
    assert main(["check", str(tmp_path / "cell")]) == 0
    assert time.process_time() - began < 5
    shown = capsys.readouterr().out
    assert "effects can be tested" in shown
    assert "backlash: joint_1" in shown
    assert main(["check", str(tmp_path / "cell"), "--json"]) == 0
    said = json.loads(capsys.readouterr().out)
    assert said["calibration"]["possible"]
    assert {one["effect"] for one in said["effects"]} == {kind.name for kind in EFFECTS}
    assert list(tmp_path.iterdir()) == [tmp_path / "cell"]


def test_a_folder_that_is_no_data_set_is_said(tmp_path, capsys):
    assert main(["check", str(tmp_path)]) == 1
    assert "has no dataset.toml" in capsys.readouterr().err


def test_radial_terms_that_a_camera_fits_itself_are_no_effect():
    made = simulate(find_robot("ur5"), kind="camera", poses=8, points=12, effects={"radial_distortion": 1e7}).dataset
    tested = {free: check_data(replace(made, parameters={} if free else made.parameters)) for free in (True, False)}
    said = {
        free: next(one for one in found.effects if one.effect == "radial_distortion") for free, found in tested.items()
    }
    assert said[True].reason == "the sensor's own k1, k2 and k3 are fitted and describe it"
    assert said[False].locations == ("camera",)


def test_a_reason_is_copied_with_its_remedy():
    copied = copy.deepcopy(NO_JOINTS)
    assert (copied, copied.remedy) == (NO_JOINTS, NO_JOINTS.remedy)
