"""What `robolaser diagnose` writes: a diagnosis, a page, and a corrected model that predicts as the diagnosis' own."""

import json
from importlib.resources import files

import jsonschema
import numpy as np
import pytest
from diagnosed import MADE
from few_files import only

from robolaser.cli import main
from robolaser.data.loading import load
from robolaser.data.result_folder import MANIFEST
from robolaser.data.stated_noise import Noise
from robolaser.data.writing import save
from robolaser.diagnosis import examine
from robolaser.diagnosis.corrected_model import corrected, corrected_json
from robolaser.diagnosis.result_json import diagnosis_json
from robolaser.export.urdf import robot_urdf
from robolaser.model.effects import candidate_effects
from robolaser.model.forward_model import Model
from robolaser.robot.by_name import find_robot
from robolaser.robot.kinematics import Robot
from robolaser.simulation import simulate

OFFSET = 0.004


def schema(name):
    return json.loads(files("robolaser").joinpath(f"schemas/{name}.schema.json").read_text())


def predicted(dataset, said):
    """Residuals of a data set by nothing but what calibration.json says, (m, 3) [m]."""
    values = {name: np.array([entry["value"]]) for name, entry in said["parameters"].items()}
    for effect in said["effects"]:
        for number, entry in effect["parameters"].items():
            values[f"{effect['effect']}.{effect['where']}.{number}"] = np.array([entry["value"]])
    wanted = [f"{effect['effect']}:{effect['where']}" for effect in said["effects"]]
    return Model(dataset, candidate_effects(wanted, dataset)).residuals_at(values)[0]


@pytest.fixture(scope="module")
def cell(tmp_path_factory):
    folder = tmp_path_factory.mktemp("diagnose") / "cell"
    made = simulate(
        find_robot("scorbot_er7"), kind="point", poses=16, noise=Noise(point_m=2e-5),
        effects={"joint_offset:joint_3": OFFSET}, seed=2,
    )  # fmt: skip
    save(made.dataset, folder)
    return folder


@pytest.fixture(scope="module")
def result(cell, tmp_path_factory):
    out = tmp_path_factory.mktemp("diagnose") / "deep" / "result"
    with only("robot_corrected.urdf"):
        assert main(["diagnose", str(cell), "--output", str(out), "--seed", "3"]) == 0
    return out


@pytest.fixture(scope="module")
def diagnosis(cell):
    """The same again, in Python."""
    return examine(load(cell), seed=3)


@pytest.fixture(scope="module")
def without(cell, tmp_path_factory):
    """The result of a smaller library, over an earlier one."""
    folder = tmp_path_factory.mktemp("without")
    before = dict.fromkeys(("diagnosis.json", "robot_corrected.urdf", "camera.yaml"), "diagnose")
    for file in before:
        (folder / file).write_text("of before")
    (folder / MANIFEST).write_text(json.dumps({"files": before}))
    geometric = ["--without", "joint_offset", "--without", "link_geometry"]
    assert main(["diagnose", str(cell), "--output", str(folder), "--force", *geometric]) == 0
    return folder


def read(path):
    return json.loads(path.read_text(encoding="utf-8"))


@pytest.mark.parametrize("name", MADE)
def test_every_diagnosis_is_what_its_schema_says(name):
    jsonschema.Draft202012Validator.check_schema(schema("diagnosis"))
    found = json.loads(json.dumps(diagnosis_json(MADE[name]()), allow_nan=False))
    jsonschema.validate(found, schema("diagnosis"))


@pytest.mark.parametrize("wrong", [{"verdict": "fine"}, {"where": None}, {"seconds": "4"}])
def test_the_schema_refuses_what_is_no_diagnosis(wrong):
    with pytest.raises(jsonschema.ValidationError):
        jsonschema.validate(diagnosis_json(MADE["explained"]()) | wrong, schema("diagnosis"))


@pytest.mark.parametrize("name", MADE)
def test_a_corrected_model_is_what_its_schema_says_and_predicts_as_the_diagnosis_does(name):
    diagnosis = MADE[name]()
    said = corrected_json(corrected(diagnosis, 1))
    jsonschema.validate(said, schema("calibration"))
    own = diagnosis.model.residuals_at(diagnosis.model.parameters.values(diagnosis.x[None]))[0]
    np.testing.assert_allclose(predicted(diagnosis.observed, said), own, rtol=0, atol=1e-12)
    assert said["objective_m2"] == pytest.approx((own**2).sum())
    assert len([one for one in said["warnings"] if "gross" in one]) == bool(len(diagnosis.outliers))


def test_the_command_writes_a_diagnosis_a_page_and_a_model(result):
    assert {path.name for path in result.iterdir()} >= {
        "diagnosis.json", "report.html", "calibration.json", "robot.urdf", "robot_corrected.urdf",
    }  # fmt: skip
    jsonschema.validate(read(result / "diagnosis.json"), schema("diagnosis"))
    jsonschema.validate(read(result / "calibration.json"), schema("calibration"))
    assert "<!DOCTYPE html>" in (result / "report.html").read_text(encoding="utf-8")


def test_the_written_model_predicts_as_the_diagnosis_own(diagnosis, result):
    own = diagnosis.model.residuals_at(diagnosis.model.parameters.values(diagnosis.x[None]))[0]
    dataset = diagnosis.observed
    np.testing.assert_allclose(predicted(dataset, read(result / "calibration.json")), own, rtol=0, atol=1e-10)
    text = (result / "robot_corrected.urdf").read_text(encoding="utf-8")
    robot = Robot.from_urdf(text, flange=dataset.robot.flange, joints=dataset.robot.joints)
    wanted = diagnosis.model.flange(diagnosis.model.parameters.values(diagnosis.x[None]))[0]
    np.testing.assert_allclose(robot.forward(dataset.poses.q[None])[0], wanted, atol=1e-9)


def test_the_same_seed_gives_the_same_answer(diagnosis, result):
    first, second = read(result / "diagnosis.json"), json.loads(json.dumps(diagnosis_json(diagnosis)))
    assert first | {"seconds": 0} == second | {"seconds": 0, "files": first["files"]}


def test_an_effect_taken_out_of_the_library_is_not_found(without):
    said = read(without / "diagnosis.json")
    assert not {"joint_offset", "link_geometry"} & {one["effect"] for one in said["effects"]}
    assert "--without joint_offset" in (without / "report.html").read_text(encoding="utf-8")


def test_nothing_of_an_overwritten_result_stays(without):
    assert not (without / "robot_corrected.urdf").exists()
    assert not (without / "camera.yaml").exists()
    assert read(without / "diagnosis.json")["format"] == "robolaser-diagnosis/1"


def test_the_sensor_is_in_the_written_robot():
    for make in MADE.values():
        text = robot_urdf(corrected(make(), 1))
        assert "scanner_camera" in text or "tool_" in text
