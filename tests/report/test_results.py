"""What `calibrate`, `diagnose` and `compare` give in Python, what changed between two of them, and the arm in them."""

import copy
import json
import pickle
import re
from pathlib import Path
from typing import Any

import jsonschema
import numpy as np
import pytest
from calibrated import KINDS
from few_files import only

import robolaser
from robolaser.cli import main
from robolaser.data.dataset import Dataset
from robolaser.data.stated_noise import Noise
from robolaser.errors import OutputError, UsageError
from robolaser.motion import simulation
from robolaser.motion.log import MotionLog
from robolaser.report.plots import VEGA_LITE
from robolaser.results import Result
from robolaser.results.calibration import CalibrationResult
from robolaser.robot.by_name import find_robot
from robolaser.scan import prepare, read_calibration
from robolaser.simulation import simulate

SCHEMAS = Path(robolaser.__file__).parent / "schemas"


@pytest.fixture(scope="module")
def dataset() -> Dataset:
    return simulate("scorbot_er7", poses=10, points=6, seed=1).dataset


def keeps_its_contract(result: Result, kind: str, folder: Path) -> None:
    said = result.to_dict()
    jsonschema.validate(said, json.loads((SCHEMAS / f"{kind}.schema.json").read_text()))
    assert len(str(result).splitlines()) > 2
    assert str(result).splitlines()[0].partition(":")[0] in result._repr_html_()
    assert len(result.to_frame().columns) > 3
    result.save(folder / kind)
    assert json.loads((folder / kind / f"{kind}.json").read_text()) == said
    assert (folder / kind / "report.html").exists()
    result.report(folder / "alone.html")
    assert (folder / "alone.html").read_text().lower().startswith("<!doctype html>")
    assert repr(result) == str(result).rstrip("\n")
    draws_its_charts(result)
    is_copied(result)
    result.save(folder / kind)  # its own earlier result
    (folder / "foreign").mkdir(exist_ok=True)
    (folder / "foreign" / "report.html").write_text("mine")
    with pytest.raises(OutputError):
        result.save(folder / "foreign")


def is_copied(result: Result) -> None:
    for copied in (pickle.loads(pickle.dumps(result)), copy.copy(result), copy.deepcopy(result)):
        assert copied.to_dict() == result.to_dict()
        assert str(copied) == str(result)


@pytest.mark.parametrize("kind", KINDS)
def test_a_calibration_of_every_sensor_is_pickled_and_copied_with_its_files(kind):
    found = CalibrationResult.of(KINDS[kind]())
    found.files()
    is_copied(found)


def test_a_diagnosis_of_a_moving_arm_is_pickled_and_copied(monkeypatch):
    monkeypatch.setattr(simulation, "DURATION_S", 5.0)
    log = simulation.simulate_motion(find_robot("ur5e"), series=1, seed=1)
    is_copied(robolaser.diagnose(log, ["offset", "torque_constant", "payload"]))


def test_a_scan_that_begins_is_pickled(dataset, tmp_path):
    robolaser.calibrate(dataset).save(tmp_path)
    scan = prepare(read_calibration(tmp_path), dataset)
    there = pickle.loads(pickle.dumps(scan))
    for one, other in zip(there.cloud.parts[0].source.pieces, scan.cloud.parts[0].source.pieces, strict=True):
        assert one().tobytes() == other().tobytes()


def draws_its_charts(result: Result) -> None:
    """All of them, or those of a title, in colours that need no style sheet."""
    every = result.plot()
    shown = every._repr_mimebundle_()
    assert "text/html" not in shown  # which JupyterLab prefers to Vega-Lite
    assert [one["title"]["text"] for one in shown[VEGA_LITE]["vconcat"]] == list(every.titles)
    pytest.importorskip("vl_convert")
    drawn = shown["image/svg+xml"]
    assert drawn.count("<path") > 10
    assert not re.search(r"NaN|var\(", drawn)
    assert result.plot(every.titles[-1].upper()).titles == every.titles[-1:]
    for unknown in ("nothere", "x"):
        with pytest.raises(UsageError, match=f"There are: {re.escape(every.titles[0])}"):
            result.plot(unknown)


def test_a_calibration_reads_like_its_file_and_is_read_back_as_the_same(tmp_path, dataset):
    found = robolaser.calibrate(dataset, effects=["laser_roll"], seed=2)
    keeps_its_contract(found, "calibration", tmp_path)
    assert len(str(found).splitlines()) <= 28
    assert found.seed == 2
    read = robolaser.load_calibration(tmp_path / "calibration")
    for one in (found, read):
        assert (
            one.value("b")
            == one.parameters["b"].value
            == one.to_frame().loc["b", "value"]
            == one["parameters"]["b"]["value"]
        )
        assert one.effects[0].parameters["angle"].value == one.value("laser_roll.laser.angle") == one.x[-1]
        assert one.std[-1] == one.effects[0].parameters["angle"].std
        with pytest.raises(UsageError, match=r"No parameter 'nothere'\. There are: f, s_u, s_v"):
            one.value("nothere")
        with pytest.raises(AttributeError):
            _ = one.nothere
    is_the_same(read, found, tmp_path, "calibration")
    assert {"rms_m", "parameters"} < set(dir(read))


def test_a_diagnosis_reads_like_its_file_and_is_read_back_as_the_same(tmp_path):
    cell = simulate("scorbot_er7", kind="point", poses=20, effects={"joint_offset:joint_2": 0.01}, seed=1).dataset
    why = robolaser.diagnose(cell, effects=["joint_offset", "target_scale"], seed=1)
    with only("corrected.py", "robot_corrected.urdf"):
        keeps_its_contract(why, "diagnosis", tmp_path)
    read = robolaser.load_diagnosis(tmp_path / "diagnosis")
    for one in (why, read):
        assert one.effects[0].parameters["offset"].value == one["effects"][0]["parameters"]["offset"]["value"]
        assert one.value("joint_offset.joint_2.offset") == pytest.approx(0.01, rel=0.1)
    is_the_same(read, why, tmp_path, "diagnosis")


@pytest.mark.parametrize("kind", ["point", "motion"])
def test_without_a_seed_python_says_what_the_command_says(tmp_path, kind, monkeypatch):
    monkeypatch.setattr(simulation, "DURATION_S", 5.0)
    data = tmp_path / "data"
    typed = ["simulate", "--robot", "scorbot_er7", "--sensor", kind, "--output", str(data)]
    assert main([*typed, *(["--poses", "12"] if kind == "point" else [])]) == 0
    asked = []

    def ask(data: Dataset | MotionLog, *options: Any, **more: Any) -> None:
        asked.append((options[:3], {name: value for name, value in more.items() if name != "progress"}))
        raise UsageError("asked")

    for place in ("robolaser.api.examine", "robolaser.motion.diagnosis.diagnose_motion"):
        monkeypatch.setattr(place, ask)
    assert main(["diagnose", str(data), "--output", str(tmp_path / "found")]) == 2
    with pytest.raises(UsageError, match="asked"):
        robolaser.diagnose(data)
    commanded, in_python = asked
    assert commanded == in_python


def is_the_same(read: Any, made: Any, folder: Path, kind: str) -> None:
    """In type, contents, charts and files."""
    assert type(read) is type(made)
    assert read.to_dict() == made.to_dict()
    assert read.plot().titles == made.plot().titles
    (folder / "again").mkdir()
    keeps_its_contract(read, kind, folder / "again")
    written, again = (sorted(file.name for file in (top / kind).iterdir()) for top in (folder, folder / "again"))
    assert written == again


def test_a_loaded_result_replaces_all_files_of_an_earlier_one(tmp_path, dataset):
    shifted = simulate("scorbot_er7", kind="point", poses=20, effects={"joint_offset:joint_2": 0.01}, seed=1).dataset
    with only("robot_corrected.urdf"):
        robolaser.calibrate(shifted, effects=["joint_offset:joint_2"]).save(tmp_path / "one")
    assert (tmp_path / "one" / "robot_corrected.urdf").exists()
    robolaser.calibrate(dataset).save(tmp_path / "plain")
    robolaser.load_calibration(tmp_path / "plain").save(tmp_path / "one")
    assert not (tmp_path / "one" / "robot_corrected.urdf").exists()


def test_a_json_file_of_another_name_is_a_result_without_the_files_beside_it(tmp_path, dataset):
    robolaser.calibrate(dataset).save(tmp_path)
    (tmp_path / "calibration.json").rename(tmp_path / "monday.json")
    robolaser.calibrate(dataset, effects=["laser_roll"]).save(tmp_path)
    monday = robolaser.load_calibration(tmp_path / "monday.json")
    assert monday.robot is None
    monday.save(tmp_path / "saved")
    assert {file.name for file in (tmp_path / "saved").glob("[!.]*")} == {"calibration.json"}
    assert robolaser.load_calibration(tmp_path / "saved").effects == []


def test_a_saved_arm_needs_only_what_the_schema_requires(tmp_path, dataset):
    made = robolaser.calibrate(dataset)
    made.save(tmp_path)
    contents = made.to_dict()
    del contents["model"]["joints"], contents["model"]["gravity"]
    (tmp_path / "calibration.json").write_text(json.dumps(contents))
    assert robolaser.load_calibration(tmp_path).robot.joints == dataset.robot.joints


@pytest.mark.parametrize("command", ["calibrate", "diagnose"])
def test_a_result_of_a_moving_arm_is_read_back_as_the_same(tmp_path, monkeypatch, command):
    monkeypatch.setattr(simulation, "DURATION_S", 5.0)
    log = simulation.simulate_motion(find_robot("ur5e"), effects={"lag:elbow_joint": 0.05}, seed=1)
    made, kind = (
        getattr(robolaser, command)(log, effects=["lag"]),
        {"calibrate": "calibration", "diagnose": "diagnosis"}[command],
    )
    keeps_its_contract(made, kind, tmp_path)
    read = getattr(robolaser, f"load_{kind}")(tmp_path / kind)
    is_the_same(read, made, tmp_path, kind)
    assert read.to_frame().equals(made.to_frame())


def test_a_path_is_a_data_set_and_a_name_is_an_effect(tmp_path, dataset):
    robolaser.save(dataset, tmp_path / "cell")
    roll = next(kind for kind in robolaser.EFFECTS if kind.name == "laser_roll")
    values = {
        robolaser.calibrate(data, effects=effects).value("laser_roll.laser.angle")
        for data, effects in ((dataset, [roll]), (str(tmp_path / "cell"), "laser_roll"))
    }
    assert max(values) == pytest.approx(min(values), rel=1e-6)
    assert robolaser.check(tmp_path / "cell").hindrance == ""
    assert len(robolaser.diagnose(tmp_path / "cell", effects="target_scale").not_testable) <= 1


@pytest.mark.parametrize(
    ("mistake", "sentence"),
    [
        (lambda data: robolaser.diagnose(data, effects=["joint_ofset"]), "Did you mean 'joint_offset'?"),
        (lambda data: robolaser.calibrate(data, effects="joint_ofset"), "Did you mean 'joint_offset'?"),
        (lambda data: robolaser.diagnose(data, effects=[{"effect": "backlash"}]), "or its class, not a dict"),
        (lambda data: robolaser.calibrate(data, effects=[{"effect": "backlash"}]), "or its class, not a dict"),
        (lambda data: robolaser.diagnose(data, without="joint_ofset"), "Did you mean 'joint_offset'?"),
        (lambda data: robolaser.diagnose(data, validate="nowhere"), "nowhere does not exist"),
        (lambda data: robolaser.load_comparison(), "Name the folder of a comparison."),
        (lambda data: robolaser.calibrate(None), "Expected a data set or the path of its folder, not a NoneType"),
        (lambda data: robolaser.diagnose(simulate("scorbot_er7", poses=5)), "Did you mean its attribute `dataset`?"),
        (lambda data: robolaser.simulate("ur5ee"), "Did you mean 'ur5e'"),
    ],
)  # fmt: skip
def test_a_natural_mistake_ends_in_a_sentence(mistake, sentence, dataset):
    with pytest.raises(robolaser.RobolaserError, match=re.escape(sentence)):
        mistake(dataset)


def test_the_package_lists_its_public_names():
    assert set(robolaser.__all__) < set(dir(robolaser))
    assert all(getattr(robolaser, name) is not None for name in dir(robolaser))
    assert re.match(r"\d", robolaser.__version__)


def test_a_comparison_is_a_result_too(tmp_path):
    told: list[tuple[str, float]] = []
    keeps_its_contract(
        robolaser.compare(
            ["pymoo:sphere-2"], ["de"], seeds=1, budget=100, progress=lambda what, share: told.append((what, share))
        ),
        "comparison",
        tmp_path,
    )
    assert re.match("[01]/1 runs", told[0][0])


def measured(offset: float, seed: int) -> robolaser.Dataset:
    noise, effects = Noise(point_m=3e-5), {"joint_offset:elbow_joint": offset}
    return simulate("ur5", kind="point", poses=25, noise=noise, effects=effects, seed=seed).dataset


def test_what_moved_is_told_in_standard_errors(tmp_path):
    with only("robot_corrected.urdf"):
        monday, friday = (
            robolaser.calibrate(measured(offset, seed), effects=["joint_offset:elbow_joint"], weights="noise", seed=0)
            for offset, seed in ((0.001, 1), (0.003, 2))
        )
    found = monday.compare(friday)
    rows = {row["name"]: row for row in found["rows"]}
    offset = rows["joint_offset.elbow_joint.offset"]
    assert offset["change"] == pytest.approx(0.002, rel=0.1)
    assert offset["errors"] > 20.0
    assert "standard errors" in repr(found)
    assert 0.3 < rows["flange of the corrected arm"]["change"] < 1.2  # mm: 2 mrad at some 0.4 m
    assert "joint_offset.elbow_joint.offset" in set(found.to_frame()["name"])
    monday.save(tmp_path / "monday")
    assert robolaser.load_calibration(tmp_path / "monday").compare(friday)["rows"] == found["rows"]


def test_a_saved_diagnosis_has_the_arm_that_it_had_when_it_was_made(tmp_path):
    noise, effects = Noise(point_m=5e-5), {"joint_offset:elbow_joint": 4e-3}
    dataset = simulate(find_robot("ur5"), kind="point", poses=20, noise=noise, effects=effects, seed=1).dataset
    with only("robot_corrected.urdf"):
        made = robolaser.diagnose(dataset, effects=["joint_offset"], seed=0)
        made.save(tmp_path / "found")
    found = robolaser.load_diagnosis(tmp_path / "found")
    q = dataset.poses.q
    np.testing.assert_allclose(found.robot.forward(q), made.robot.forward(q), atol=1e-9)
    assert np.abs(made.robot.forward(q) - dataset.robot.forward(q)).max() > 1e-3
    assert "robot" in dir(found)


def test_poses_may_have_fewer_axes():
    robot = find_robot("ur5")
    q = np.random.default_rng(0).uniform(-1.0, 1.0, (5, 6))
    (T,), (J,) = robot.forward(q[None]), robot.jacobian(q[None])
    np.testing.assert_array_equal(robot.forward(q), T)
    np.testing.assert_array_equal(robot.forward(q[2].tolist()), T[2])
    np.testing.assert_array_equal(robot.jacobian(q), J)
    np.testing.assert_array_equal(robot.jacobian(q[2].tolist()), J[2])


def test_a_value_too_few_is_said():
    with pytest.raises(UsageError, match="5 joint values for each pose, but ur5 has 6 joints"):
        find_robot("ur5").forward(np.zeros((3, 5)))
