"""A calibration's file is enough to scan with, and says so where it is not."""

import json
from dataclasses import replace

import numpy as np
import pytest
from cells import on_flange_poses
from scanned import calibrated, dataset, written

from robolaser.errors import DataError, EffectError, ScanError
from robolaser.model.effects import EFFECTS
from robolaser.model.effects.run import RunSummary
from robolaser.scan import prepare, read_calibration


@pytest.fixture(scope="module")
def data():
    return dataset()


@pytest.fixture
def folder(data, tmp_path):
    return written(calibrated(data, ["backlash:joint_2"], {"backlash.joint_2.lost_motion": 0.01}), tmp_path)


def change(folder, path, value):
    """Put something else at a path of the file; `...` takes it away."""
    whole = json.loads((folder / "calibration.json").read_text())
    at = whole
    *way, last = path
    for key in way:
        at = at[key]
    if value is ...:
        del at[last]
    else:
        at[last] = value
    (folder / "calibration.json").write_text(json.dumps(whole))


def test_what_was_calibrated_is_read(folder, data):
    for path in (folder, folder / "calibration.json"):
        read = read_calibration(path)
        assert read.values["f"] == data.parameters["f"].nominal
        assert read.values["backlash.joint_2.lost_motion"] == 0.01
        assert read.robot.joints == data.robot.joints
        assert read.run == RunSummary.of(data)
        np.testing.assert_allclose(read.robot.forward(data.poses.q[None]), data.robot.forward(data.poses.q[None]))


@pytest.mark.parametrize(
    ("path", "value", "said"),
    [
        (("format",), "robolaser-calibration/9", "expected the format robolaser-calibration/1, not 'robo"),
        (("model", "sensor"), "camera", "[model] sensor: 'camera', expected \"stripe\""),
        (("parameters", "theta"), ..., "it has no theta"),
        (("parameters", "theta", "value"), None, "[parameters] theta.value: None, expected a finite number"),
        (("parameters", "theta", "value"), float("nan"), "not JSON"),
        (("parameters", "b", "value"), -(10**400), "[parameters] b.value: -1000"),
        (("parameters", "s_u", "value"), 0, "parameters.s_u.value is 0, not above 0"),
        (("model", "bracket_quat"), [0, 0, 0, 2], "length 2"),
        (("model", "image"), [640, 0], "[model] image, entry 2: 0, expected a whole number"),
        (("run", "poses"), 0, "[run] poses: 0, expected a whole number from 1"),
        (("noise", "joint"), -1e-5, "[noise] joint: -1e-05, expected a number, 0 or more"),
        (("rms_m",), -1, "rms_m: -1, expected a number, 0 or more"),
        (("effects", 0, "where"), "elbow", "backlash cannot be at 'elbow'. There are: joint_1"),
        (("effects", 0, "where"), "laser", "backlash cannot be at 'laser'. There are: joint_1"),
        (("effects", 0, "effect"), "backlashh", "Did you mean 'backlash'"),
        (("model", "robot"), "../robot.urdf", "robot"),
        (("effects", 0, "parameters"), {}, "it has no backlash.joint_2.lost_motion"),
        (("dataset",), "\ud800", "not JSON"),
    ],
)
def test_what_is_wrong_is_named(folder, path, value, said):
    change(folder, path, value)
    with pytest.raises((DataError, EffectError)) as wrong:
        read_calibration(folder)
    assert said in str(wrong.value)


def test_the_noise_of_the_scanner_is_known_also_beside_its_camera(folder):
    change(folder, ("model", "sensors"), [{"name": "light", "kind": "stripe"}, {"name": "camera", "kind": "camera"}])
    change(folder, ("noise",), {"light.pixel": 0.2, "camera.pixel": 0.1, "joint": 1e-5})
    assert read_calibration(folder).noise == {"pixel": 0.2, "camera.pixel": 0.1, "joint": 1e-5}


def test_an_effect_that_is_there_twice_is_named(folder):
    change(folder, ("effects",), 2 * json.loads((folder / "calibration.json").read_text())["effects"])
    with pytest.raises(DataError, match="backlash at joint_2 twice"):
        read_calibration(folder)


@pytest.mark.parametrize("robot", [True, False], ids=["arm", "flange poses"])
def test_every_effect_is_read_at_every_place_that_it_was_found_at(robot, data, tmp_path):
    if not robot:
        data = on_flange_poses(data)
    names = [kind.name for kind in EFFECTS if kind.locations(data)]
    assert len(names) > (12 if robot else 5)
    calibration = calibrated(data, names)
    read = read_calibration(written(calibration, tmp_path))
    assert read.candidates == calibration.model.effects
    assert len(read.candidates) > len(names) or not robot


def test_where_there_are_no_joints_nothing_sits_in_one(data, tmp_path):
    folder = written(calibrated(on_flange_poses(data), ["laser_roll"]), tmp_path)
    for where in ("laser", "joint_2"):
        numbers = {"offset": {"value": 1, "std": None}}
        change(folder, ("effects", 0), {"effect": "joint_offset", "where": where, "parameters": numbers})
        with pytest.raises(EffectError, match="joint_offset cannot be at"):
            read_calibration(folder)


@pytest.mark.parametrize("text", ["[" * 100_000, '{"format": ' * 50_000, '{"x": ' * 50_000, "9" * 5000])
def test_a_file_that_goes_too_deep_is_named(text, folder):
    (folder / "calibration.json").write_text(text)
    with pytest.raises(DataError, match=r"Cannot read .*calibration\.json"):
        read_calibration(folder)


def test_a_file_that_is_not_there_or_no_json_is_told(folder):
    (folder / "robot.urdf").unlink()
    with pytest.raises(DataError, match=r"robot\.urdf"):
        read_calibration(folder)
    (folder / "calibration.json").write_text("{")
    with pytest.raises(DataError, match="not JSON"):
        read_calibration(folder)


def test_a_folder_that_holds_no_calibration_is_answered_with_where_one_comes_from(tmp_path):
    with pytest.raises(DataError, match=r"at .*nowhere\. Name a folder that `robolaser calibrate`"):
        read_calibration(tmp_path / "nowhere")
    with pytest.raises(DataError, match=r"no calibration\.json"):
        read_calibration(tmp_path)


def test_older_files_that_say_nothing_of_run_and_noise_are_read(folder):
    for key in ("run", "noise"):
        change(folder, (key,), ...)
    change(folder, ("model", "gravity"), ...)
    read = read_calibration(folder)
    assert read.run is None
    assert read.robot.gravity == (0.0, 0.0, -9.81)


def unguessed(data):
    """The same data, nobody having given a first guess of the scanner: the numbers are closed forms."""
    items = {name: replace(item, given=False, origin="the board's corners") for name, item in data.parameters.items()}
    return replace(data, parameters=items)


def test_a_scanner_that_was_calibrated_without_a_guess_scans_as_well_as_one_with(data, tmp_path):
    clouds = []
    for name, one in (("given", data), ("unguessed", unguessed(data))):
        folder = written(calibrated(one, ["laser_roll"], {"laser_roll.laser.angle": 0.1}), tmp_path / name)
        pieces = prepare(read_calibration(folder), data).cloud.pieces(lambda what, share: None)
        clouds.append(np.concatenate(list(pieces)))
    assert len(clouds[0])
    assert clouds[0].tobytes() == clouds[1].tobytes()


def test_a_scanner_without_nominal_values_cannot_be_drawn_and_says_so(data, tmp_path):
    with pytest.raises(ScanError, match="no nominal model"):
        read_calibration(written(calibrated(unguessed(data)), tmp_path)).as_drawn()
