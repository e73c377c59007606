"""A calibration's file is enough to scan with, and says so where it is not."""

import json

import numpy as np
import pytest
from scanned import calibrated, dataset, written

from robolaser.effects.run import Run
from robolaser.errors import CalibrationUnreadable, EffectForeign, FileUnreadable, FormatUnknown, PathLeaves
from robolaser.scan import read_calibration


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
        assert read.run == Run.of(data)
        np.testing.assert_allclose(read.robot.forward(data.poses.q[None]), data.robot.forward(data.poses.q[None]))


@pytest.mark.parametrize(
    ("path", "value", "said"),
    [
        (("parameters", "theta"), ..., "no parameters.theta"),
        (("parameters", "theta", "value"), None, "parameters.theta.value is no finite number"),
        (("parameters", "theta", "value"), True, "no finite number"),
        (("parameters", "theta", "nominal"), "0.4", "no finite number"),
        (("parameters",), [], "parameters is no object"),
        (("model", "sensor"), "point", "'point'"),
        (("model", "stripe_axis"), "w", "one of u, v"),
        (("model", "bracket_quat"), [0, 1], "4 numbers"),
        (("model", "joints"), "joint_1", "list of texts"),
        (("effects",), {}, "effects is no list"),
        (("effects", 0, "where"), "elbow", "'elbow'"),
        (("effects", 0, "parameters"), {}, "no effects[0].parameters.lost_motion"),
        (("dataset",), 3, "dataset is no text"),
        (("run", "poses"), ..., "no run.poses"),
    ],
)
def test_what_is_wrong_is_named(folder, path, value, said):
    change(folder, path, value)
    with pytest.raises(CalibrationUnreadable) as wrong:
        read_calibration(folder)
    assert said in str(wrong.value)


def test_an_effect_from_elsewhere_is_named(folder):
    change(folder, ("effects", 0, "effect"), "backlashh")
    with pytest.raises(EffectForeign, match="Did you mean 'backlash'"):
        read_calibration(folder)


def test_another_format_is_named(folder):
    change(folder, ("format",), "robolaser-calibration/9")
    with pytest.raises(FormatUnknown):
        read_calibration(folder)


def test_a_robot_elsewhere_is_not_read(folder):
    change(folder, ("model", "robot"), "../robot.urdf")
    with pytest.raises(PathLeaves):
        read_calibration(folder)


def test_a_file_that_is_not_there_or_no_json_is_told(folder):
    (folder / "robot.urdf").unlink()
    with pytest.raises(FileUnreadable, match=r"robot\.urdf"):
        read_calibration(folder)
    (folder / "calibration.json").write_text("{")
    with pytest.raises(CalibrationUnreadable, match="no JSON"):
        read_calibration(folder)


def test_older_files_that_say_nothing_of_run_and_noise_are_read(folder):
    for key in ("run", "noise"):
        change(folder, (key,), ...)
    change(folder, ("model", "gravity"), ...)
    read = read_calibration(folder)
    assert read.run is None
    assert read.robot.gravity == (0.0, 0.0, -9.81)
