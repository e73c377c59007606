"""What `robolaser view` says before anything is to be seen."""

import json
import sys
from dataclasses import replace

import numpy as np
import pytest
from emulated_cell import cell_folder
from scanned import calibrated, dataset, laser_planes, recorded, written

import robolaser
from robolaser.cli import main
from robolaser.data.dataset import Points
from robolaser.geometry.rigid_motion import apply, inverse
from robolaser.scan import read_calibration
from robolaser.scan.scanner_model import carried_over


@pytest.fixture(scope="module")
def cell(tmp_path_factory):
    folder = tmp_path_factory.mktemp("view")
    data = dataset(poses=6)
    written(calibrated(data, ["laser_drift"], {"laser_drift.laser.angle": 0.01}), folder / "calibration")
    recorded(data, folder / "data")
    recorded(dataset(poses=6, seed=2), folder / "elsewhere")
    return folder


@pytest.mark.parametrize("port", ["70000", "0", "-1", "http"])
def test_a_port_that_there_is_not_is_wrong_usage(port, cell, capsys):
    assert main(["view", str(cell / "data"), f"--port={port}"]) == 2
    assert port in capsys.readouterr().err


def test_without_what_draws_the_scene_it_says_how_to_get_it(cell, monkeypatch, capsys):
    monkeypatch.setitem(sys.modules, "viser", None)
    assert main(["view", str(cell / "data"), "--no-browser"]) == 1
    assert "robolaser[view]" in capsys.readouterr().err


@pytest.mark.parametrize(("name", "told"), [("data", False), ("elsewhere", True)])
def test_what_is_not_known_about_another_run_is_told(name, told, cell, served, capsys):
    assert main(["view", str(cell / name), str(cell / "calibration"), "--no-browser"]) == 0
    assert ("laser_drift at laser" in capsys.readouterr().err) is told
    assert [model.name for model in served[0][0]] == ["nominal", "calibrated"]


def test_a_calibration_for_images_of_another_size_is_refused(cell, tmp_path, served, capsys):
    data = dataset(poses=6)
    width, height = data.image_px
    recorded(replace(data, image_px=(2 * width, height)), tmp_path / "data")
    assert main(["view", str(tmp_path / "data"), str(cell / "calibration"), "--no-browser"]) == 1
    said = " ".join(capsys.readouterr().err.split())
    assert f"has images of {2 * width} x {height} px" in said
    assert f"a camera with {width} x {height} px" in said
    assert not served


LEFT_OUT = "backlash at joint_2 is left out: the order of the poses is not known"
AFTER_IT = "base_shift at base: the cell is taken as it was after the shift"
AS_WARM = "thermal_drift at joint_2: how far it has come in this recording is not known"


@pytest.mark.parametrize(
    ("columns", "told"),
    [
        (["time_s", "temperature_c"], {LEFT_OUT, AFTER_IT, AS_WARM}),
        (["temperature_c"], {AFTER_IT, AS_WARM}),
        ([], set()),
    ],
)
def test_a_recording_that_lacks_what_effects_need_is_shown_as_it_is_scanned(columns, told, tmp_path, served, capsys):
    data = dataset(poses=8)
    data = replace(data, poses=replace(data.poses, temperature_c=np.linspace(20.0, 30.0, 8)))
    numbers = {
        "laser_drift.laser.angle": 0.01,
        "thermal_drift.joint_2.growth": 0.001,
        "backlash.joint_2.lost_motion": 0.001,
        "base_shift.base.turn_z": 0.01,
    }
    effects = [name.rpartition(".")[0].replace(".", ":") for name in numbers]
    found = read_calibration(written(calibrated(data, effects, numbers), tmp_path / "calibration"))
    bare = replace(data, poses=replace(data.poses, **dict.fromkeys(columns)), points=Points(np.empty(0, np.int64), ()))
    bare = recorded(bare, tmp_path / "data")
    assert main(["view", str(tmp_path / "data"), str(tmp_path / "calibration"), "--no-browser"]) == 0
    said, shown = " ".join(capsys.readouterr().err.split()), served[-1][0][-1]
    assert {one for one in (LEFT_OUT, AFTER_IT, AS_WARM) if one in said} == told
    scanner, _ = carried_over(found, found.fitted_to(bare), data.points)
    np.testing.assert_allclose(shown.camera, scanner.camera, atol=1e-12)
    light, plane = apply(inverse(shown.camera[3]), shown.at_pose(3).light), laser_planes(scanner)[3]
    np.testing.assert_allclose(light @ plane[:3], plane[3], atol=1e-12)


@pytest.mark.parametrize(
    "said",
    [{}, {"format": ""}, {"effects": [], "model": []}, {"effects": [{"effect": "backlash"}], "model": {}}],
    ids=str,
)
def test_a_calibration_with_something_missing_is_told(said, cell, tmp_path, served, capsys):
    (tmp_path / "half.json").write_text(json.dumps({"format": "robolaser-calibration/1", **said}))
    assert main(["view", str(cell / "data"), str(tmp_path / "half.json"), "--no-browser"]) == 1
    assert "half.json" in "".join(capsys.readouterr().err.splitlines())


def test_a_table_of_poses_is_shown_with_what_it_would_hit(served, tmp_path, capsys):
    folder = cell_folder(tmp_path)
    with (folder / "cell.toml").open("a") as file:
        file.write('[[box]]\nname = "post"\ncentre_m = [0.35, 0.2, 0.3]\nsize_m = [0.05, 0.05, 0.6]\n')
    poses = tmp_path / "poses.csv"
    poses.write_text("pose,q_joint_1,q_joint_2,q_joint_3,q_joint_4,q_joint_5\ninto,0.52,-0.4,0.6,0,0\n")
    assert main(["view", str(poses), "--cell", str(folder), "--no-browser"]) == 0
    (models, _, _, collisions) = served[-1]
    assert models[0].dataset.poses.names == ("into",)
    assert "link_3 and post overlap by" in collisions(models[0].dataset.poses.q[0])[0]
    assert main(["view", str(poses), "--no-browser"]) != 0


def test_a_cell_of_another_arm_is_wrong_usage(cell, served, tmp_path, capsys):
    folder = cell_folder(tmp_path)
    text = (folder / "robot.urdf").read_text()
    (folder / "robot.urdf").write_text(text.replace('"joint_1"', '"axis_1"'))
    described = (folder / "dataset.toml").read_text()
    (folder / "dataset.toml").write_text(described.replace('"joint_1"', '"axis_1"'))
    assert main(["view", str(cell / "data"), "--cell", str(folder), "--no-browser"]) == 2
    assert "axis_1" in capsys.readouterr().err


def test_a_scanner_that_nobody_guessed_is_shown_as_it_was_calibrated(cell, tmp_path, served, capsys):
    data = dataset(poses=6)
    unguessed = replace(data, parameters={name: replace(one, given=False) for name, one in data.parameters.items()})
    written(calibrated(unguessed), tmp_path / "calibration")
    recorded(replace(data, parameters={}), tmp_path / "data")
    assert main(["view", str(tmp_path / "data"), str(tmp_path / "calibration"), "--no-browser"]) == 0
    ((models, *_),) = served
    assert [model.name for model in models] == ["calibrated"]
    assert main(["view", str(tmp_path / "data"), "--no-browser"]) != 0
    assert "name a calibration" in " ".join(capsys.readouterr().err.split())


def test_a_scanner_whose_images_show_a_board_is_shown_with_its_effects(tmp_path, served):
    typed = ["simulate", "--robot", "scorbot_er7", "--sensor", "stripe+camera", "--poses", "8", "--output"]
    assert main([*typed, str(tmp_path / "data"), "--effect", "laser_roll=0.1", "--quiet"]) == 0
    found = robolaser.calibrate(tmp_path / "data", effects=["laser_roll"])
    found.save(tmp_path / "result")
    assert main(["view", str(tmp_path / "data"), str(tmp_path / "result"), "--no-browser", "--quiet"]) == 0
    shown = served[-1][0][-1]
    assert len(shown.at(shown.dataset.poses.q[1]).light) > 10
    apart = np.linalg.norm(shown.points - shown.target, axis=1)
    assert np.sqrt(np.mean(apart**2)) == pytest.approx(found.rms_m, rel=0.02)
