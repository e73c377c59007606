"""Each file of a diagnosis says what it delivers, and delivers that."""

import json
import re
import xml.etree.ElementTree as ET
from collections.abc import Iterable
from dataclasses import replace
from importlib.resources import files

import jsonschema
import numpy as np
import pytest
from few_files import only

import robolaser
from robolaser.calibration.calibrate import calibrate
from robolaser.calibration.plan import Plan
from robolaser.data.dataset import Dataset, Poses
from robolaser.data.stated_noise import Noise
from robolaser.export.mjcf import mjcf
from robolaser.report.console import printed
from robolaser.report.document import Document
from robolaser.report.setting import files_section
from robolaser.results.calibration import CalibrationResult
from robolaser.results.delivered import _by_mujoco
from robolaser.results.diagnosis import DiagnosisResult
from robolaser.robot.by_name import find_robot
from robolaser.robot.kinematics import Robot
from robolaser.simulation import CellOptions, Simulated, simulate

EFFECTS = {"joint_offset:elbow_joint": 2e-3, "joint_compliance:shoulder_lift_joint": 5e-5}


def made(seed: int) -> Simulated:
    return simulate(find_robot("ur5"), kind="point", poses=24, noise=Noise(point_m=3e-5), effects=EFFECTS, seed=seed)


@pytest.fixture(scope="module")
def why() -> DiagnosisResult:
    return robolaser.diagnose(made(1).dataset, effects=["joint_offset", "joint_compliance"], seed=0)


def delivered(data: Dataset, effects: Iterable[str], *files: str, **how: str) -> tuple[float, list[float]]:
    """The error of a calibration on new poses and those of its files [mm]."""
    with only(*files):
        found = robolaser.calibrate(data, effects=list(effects), seed=0, **how)
    errors = {one["file"]: one["held_out_mm"] for one in found["files"]}
    return 1e3 * found.held_out_rms_m, [errors[file] for file in files]


def by_name(why: DiagnosisResult) -> dict[str, dict[str, object]]:
    return {one["file"]: one for one in why.to_dict()["files"]}


def test_a_file_that_holds_all_delivers_what_the_page_promises(why):
    assert by_name(why)["corrected.py"]["lacks"] == []
    assert by_name(why)["corrected.py"]["held_out_mm"] == pytest.approx(why.gap_mm.after, rel=0.1)


def test_a_file_that_cannot_hold_a_spring_says_so_and_delivers_less(why):
    urdf = by_name(why)["robot_corrected.urdf"]
    assert urdf["lacks"] == [["joint_compliance", "shoulder_lift_joint"]]
    assert float(str(urdf["held_out_mm"])) > 3.0 * why.gap_mm.after
    assert by_name(why)["robot_corrected.sdf"]["held_out_mm"] == pytest.approx(urdf["held_out_mm"], rel=1e-6)


def test_corrected_py_does_not_hold_what_happened_in_one_of_several_sessions():
    noise, sessions = Noise(point_m=3e-5), CellOptions(sessions=2)
    sound = simulate("ur5", kind="point", poses=20, noise=noise, options=sessions, seed=2).dataset
    late = (sound.session_of_pose == 1) & (np.arange(40) >= 30)
    xyz = sound.points.xyz + 1e-3 * late[sound.points.pose, None]
    moved = replace(sound, points=replace(sound.points, xyz=xyz))
    with only("corrected.py"):
        (file,) = robolaser.calibrate(moved, effects=["base_shift"], seed=0)["files"]
    assert file["lacks"] == [["base_shift", "base"]]


def test_a_scale_that_may_be_the_arm_s_is_lacking_in_its_files(tmp_path):
    effects = {"tracker_scale:measuring_system": 5e-4, "joint_offset:elbow_joint": 2e-3}
    made = simulate("ur5", kind="point", poses=12, noise=Noise(point_m=3e-5), effects=effects, seed=2)
    robolaser.calibrate(made.dataset, effects=list(effects), seed=0).save(tmp_path / "found")
    written = json.loads((tmp_path / "found" / "calibration.json").read_text(encoding="utf-8"))["files"]
    assert "corrected.py" in [one["file"] for one in written]
    assert all(one["lacks"] == [["tracker_scale", "measuring_system"]] for one in written)


def test_mujoco_is_asked_where_it_is_installed(why):
    pytest.importorskip("mujoco")
    assert by_name(why)["robot_corrected.xml"]["held_out_mm"] == pytest.approx(why.gap_mm.after, rel=0.2)


def test_where_mujoco_is_not_installed_the_page_says_what_to_install(monkeypatch):
    unread = {"file": "robot_corrected.xml", "held_out_mm": None, "contains": [], "lacks": []}
    monkeypatch.setattr("robolaser.export.files.find_spec", lambda name: None)
    assert "not known; needs `pip install 'robolaser[mujoco]'`" in printed(
        Document("", "", "", "", "", [], [files_section([unread])])
    )


def test_the_schema_knows_them_and_the_page_leads_to_each(why, tmp_path):
    why.save(tmp_path / "why")
    written = json.loads((tmp_path / "why" / "diagnosis.json").read_text(encoding="utf-8"))
    jsonschema.validate(written, json.loads(files("robolaser.schemas").joinpath("diagnosis.schema.json").read_text()))
    assert "error on new poses, base and tool re-fitted" in str(why)
    page = (tmp_path / "why" / "report.html").read_text(encoding="utf-8")
    for one in why["files"]:
        assert f'<a href="{one["file"]}">' in page
        assert (tmp_path / "why" / one["file"]).is_file()


def test_the_error_is_that_of_the_file_on_other_poses(why, tmp_path):
    """By a user's own means: the URDF's flange poses as measured ones, with base and tool fitted to the points."""
    other = made(2).dataset
    why.save(tmp_path / "why")
    text = (tmp_path / "why" / "robot_corrected.urdf").read_text(encoding="utf-8")
    flange = Robot.from_urdf(text, flange=other.robot.flange).forward(other.poses.q[None])[0]
    seen = replace(other, robot=None, poses=Poses(other.poses.names, T_base_flange=np.asarray(flange)))
    found = robolaser.calibrate(seen)
    assert 1e3 * found["rms_m"] == pytest.approx(by_name(why)["robot_corrected.urdf"]["held_out_mm"], rel=0.25)


def test_an_arm_without_errors_needs_no_files():
    sound = simulate(find_robot("ur5"), kind="point", poses=30, noise=Noise(point_m=3e-5), seed=1).dataset
    assert robolaser.diagnose(sound, effects=["joint_offset"], seed=0)["files"] == []


@pytest.mark.parametrize("weights", ["plain", "noise"])
def test_a_calibration_with_effects_of_the_arm_says_likewise_what_its_files_deliver(weights, tmp_path):
    with only("corrected.py", "robot_corrected.urdf"):
        found = robolaser.calibrate(made(1).dataset, effects=list(EFFECTS), weights=weights, seed=0)
    found.save(tmp_path / "found")
    written = json.loads((tmp_path / "found" / "calibration.json").read_text(encoding="utf-8"))
    jsonschema.validate(written, json.loads(files("robolaser.schemas").joinpath("calibration.schema.json").read_text()))
    module, urdf = ({one["file"]: one for one in written["files"]}[f] for f in ("corrected.py", "robot_corrected.urdf"))
    assert module["held_out_mm"] == pytest.approx(1e3 * found.held_out_rms_m, rel=0.1)
    assert urdf["lacks"] == [["joint_compliance", "shoulder_lift_joint"]]
    assert urdf["held_out_mm"] > 3.0 * module["held_out_mm"]
    assert "robot_corrected.urdf" in (tmp_path / "found" / "report.html").read_text(encoding="utf-8")


def test_exported_files_have_no_large_corrections_that_the_data_do_not_determine():
    """A reflector on the last axis says next to nothing about this axis: the best fit turns it by ten degrees."""
    data = simulate("ur5", kind="point", poses=40, points=1, effects={"joint_offset:elbow_joint": 2e-3}, seed=1).dataset
    flange = data.robot.forward(data.poses.q + 2e-3 * (np.arange(6) == 2))
    on_axis = flange[:, :3, 3] + 0.03 * flange[:, :3, 2] + np.random.default_rng(1).normal(0.0, 1e-4, (40, 3))
    data = replace(data, points=replace(data.points, xyz=on_axis[data.points.pose]))
    with only("robot_corrected.urdf"):
        found = robolaser.calibrate(data, effects=["joint_offset", "link_geometry"], seed=0)
    zero, nominal = np.zeros((1, 6)), data.robot
    assert np.abs(found.calibration.robot.forward(zero) - nominal.forward(zero)).max() > 0.05
    assert np.abs(found.robot.forward(zero) - nominal.forward(zero)).max() < 0.005
    assert found["files"][0]["held_out_mm"] < 1.1e3 * found.held_out_rms_m
    assert "the values nearest to nominal" in str(found).replace("\n", " ")


def test_play_is_replayed_along_the_path():
    pytest.importorskip("mujoco")
    noise, play = Noise(point_m=3e-5), {"backlash:elbow_joint": 2e-3, "backlash:wrist_2_joint": 3e-3}
    data = simulate(find_robot("ur5"), kind="point", poses=41, noise=noise, effects=play, seed=2).dataset
    data = data.of_poses(np.arange(41) > 0)  # where the arm came from to its first pose is not known
    own, (module, xml) = delivered(data, play, "corrected.py", "robot_corrected.xml", weights="noise")
    without = robolaser.calibrate(data, weights="noise", seed=0)
    assert module == pytest.approx(own, rel=0.1)
    assert xml < 1.1 * module < 0.3e3 * without.held_out_rms_m


def test_a_heavy_arm_on_a_soft_gear_is_at_rest_where_its_file_is_tested():
    pytest.importorskip("mujoco")
    noise, soft = Noise(point_m=2e-5), {"joint_compliance:shoulder_lift_joint": 1e-4}
    data = simulate("ur10", kind="point", poses=20, noise=noise, effects=soft, seed=3).dataset
    _, (module, xml) = delivered(data, soft, "corrected.py", "robot_corrected.xml")
    assert xml < 2.0 * module


def test_the_path_of_each_session_is_its_own():
    play, options = {"backlash:elbow_joint": 3e-3}, CellOptions(sessions=2)
    noise = Noise(point_m=3e-5)
    data = simulate(
        find_robot("ur5"), kind="point", poses=25, noise=noise, effects=play, options=options, seed=3
    ).dataset
    assert data.poses.time_s[0] == data.poses.time_s[25]
    own, (module,) = delivered(data, play, "corrected.py", weights="noise")
    assert module == pytest.approx(own, rel=0.2)


@pytest.fixture(scope="module")
def bent() -> CalibrationResult:
    """Of an arm whose elbow has a wrong zero and a wrong gain, measured where a gain is mostly an offset, too."""
    effects = {"joint_offset:elbow_joint": 2e-3, "encoder_scale:elbow_joint": 5e-3}
    noise = Noise(point_m=3e-5)
    data = simulate(find_robot("ur5"), kind="point", poses=80, noise=noise, effects=effects, seed=1).dataset
    data = data.of_poses(data.arm[1][:, 2] > 0.8)
    with only("robot_corrected.urdf", "robot_corrected.sdf"):
        return robolaser.calibrate(data, effects=list(effects), weights="noise", seed=0)


def test_gazebo_gets_the_geometry_that_other_tools_get(bent, tmp_path):
    bent.save(tmp_path / "found")
    urdf, sdf = (ET.parse(tmp_path / "found" / f"robot_corrected.{name}") for name in ("urdf", "sdf"))
    origin = {one.get("name"): one.find("origin") for one in urdf.getroot().findall("joint")}["elbow_joint"]
    child = {one.get("name"): one.findtext("child") for one in sdf.iter("joint")}["elbow_joint"]
    (placed,) = (one.findtext("pose") for one in sdf.iter("link") if one.get("name") == child)
    stated = f"{origin.get('xyz')} {origin.get('rpy')}".split()
    assert [float(number) for number in placed.split()] == pytest.approx([float(number) for number in stated], abs=1e-9)


@pytest.mark.parametrize("sessions", [1, 2])
def test_poses_in_an_order_without_times_warm_the_delivered_arm_as_they_warmed_the_model(sessions):
    options, drift = CellOptions(sessions=sessions), "thermal_drift:elbow_joint"
    noise = Noise(point_m=2e-5)
    timed = simulate("ur5", kind="point", poses=24, noise=noise, effects={drift: 4e-3}, options=options, seed=2).dataset
    poses = replace(timed.poses, time_s=10.0 * np.argsort(np.argsort(timed.poses.time_s)))
    own, (module,) = delivered(replace(timed, poses=poses, time_is_order=True), [drift], "corrected.py")
    assert module == pytest.approx(own, rel=0.15)


def test_a_bracket_that_creeps_has_crept_only_so_far_where_a_file_is_tested():
    effects = {"joint_offset:elbow_joint": 2e-3, "hand_eye_drift": 3e-3}
    noise = Noise(pixel_px=0.1)
    data = simulate("ur5", kind="camera", poses=24, noise=noise, effects=effects, seed=1).dataset
    own, (urdf,) = delivered(data, effects, "robot_corrected.urdf")
    assert urdf == pytest.approx(own, rel=0.15)


def test_the_arm_of_a_result_is_the_one_that_its_folder_holds(bent, tmp_path):
    bent.save(tmp_path / "found")
    q = np.random.default_rng(0).uniform(-2.0, 2.0, (20, 6))
    here, there = (one.robot for one in (bent, robolaser.load_calibration(tmp_path / "found")))
    np.testing.assert_allclose(here.forward(q), there.forward(q), atol=1e-12)
    assert "robot" in dir(robolaser.load_calibration(tmp_path / "found"))
    assert np.abs(here.forward(q) - bent.calibration.robot.forward(q)).max() > 1e-4


def test_results_of_other_data_are_told_from_results_of_the_same(why, tmp_path):
    other = robolaser.diagnose(made(2).dataset, effects=[], seed=0)
    for name, one in (("one", why), ("other", other)):
        one.save(tmp_path / name)
    read, others = (robolaser.load_diagnosis(tmp_path / name) for name in ("one", "other"))
    assert why.compare(read)["same_data"]
    assert not why.compare(other)["same_data"]
    assert not others.compare(read)["same_data"]


def test_files_are_held_against_every_shot_where_each_was_fitted():
    noise, options = Noise(point_m=3e-5), CellOptions(repeats=2, sessions=2)
    effects = {"joint_offset:elbow_joint": 2e-3}
    data = simulate("ur5", kind="point", poses=30, noise=noise, effects=effects, options=options, seed=4).dataset
    own, (module,) = delivered(data, effects, "corrected.py")
    assert module == pytest.approx(own, rel=0.1)


def test_an_arm_that_flies_apart_in_mujoco_is_nowhere_and_leaves_no_trace(tmp_path, monkeypatch):
    pytest.importorskip("mujoco")
    data, effects = made(1).dataset, ("joint_compliance:shoulder_lift_joint", "joint_compliance:elbow_joint")
    text = mjcf(calibrate(data, Plan(effects=effects)))
    some = np.arange(len(data.poses)) < 3
    monkeypatch.chdir(tmp_path)
    assert np.isfinite(_by_mujoco(text, data, some)).all()
    assert np.isnan(_by_mujoco(re.sub(r' stiffness="[^"]*"', ' stiffness="1e20"', text), data, some)).all()
    assert list(tmp_path.iterdir()) == []


def test_base_and_tool_are_not_fitted_to_the_poses_that_a_file_must_predict():
    """With few poses they would imitate much of the effect that a file lacks, and of the noise."""
    effects = {"encoder_eccentricity:shoulder_lift_joint": 1e-3}
    data = simulate("ur5", kind="point", poses=12, noise=Noise(point_m=3e-5), effects=effects, seed=3).dataset
    own, (module, sdf) = delivered(data, effects, "corrected.py", "robot_corrected.sdf", weights="noise")
    without = robolaser.calibrate(data, weights="noise", seed=0)
    assert module == pytest.approx(own, rel=0.02)
    assert sdf == pytest.approx(1e3 * without.held_out_rms_m, rel=0.02)


def test_base_is_placed_in_each_of_many_short_sessions():
    effects, sessions = {"joint_offset:elbow_joint": 4e-3}, CellOptions(sessions=12)
    noise = Noise(point_m=3e-5)
    data = simulate("ur5", kind="point", poses=6, noise=noise, effects=effects, options=sessions, seed=1).dataset
    own, (urdf,) = delivered(data, effects, "robot_corrected.urdf", weights="noise")
    assert urdf == pytest.approx(own, rel=0.05)
