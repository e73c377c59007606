"""Two results side by side."""

import json
from pathlib import Path
from typing import Any

import pytest

import robolaser
from robolaser.cli import main
from robolaser.robot.by_name import find_robot
from robolaser.simulation import simulate


@pytest.fixture(scope="module")
def folder(tmp_path_factory: pytest.TempPathFactory) -> Path:
    made = tmp_path_factory.mktemp("results")
    data = simulate(find_robot("scorbot_er7"), poses=12, points=6, effects={"laser_roll": 0.05}, seed=1).dataset
    robolaser.calibrate(data).save(made / "plain")
    robolaser.calibrate(data, effects=["laser_roll"]).save(made / "rolled")
    robolaser.diagnose(data, effects=["laser_roll"], seed=0).save(made / "why")
    return made


def rows(folder: Path, first: str, second: str, capsys: pytest.CaptureFixture[str]) -> dict[str, dict[str, Any]]:
    assert main(["diff", str(folder / first), str(folder / second), "--json"]) == 0
    return {row["name"]: row for row in json.loads(capsys.readouterr().out)["rows"]}


def test_a_number_changes_by_what_the_files_say(folder, capsys):
    found = rows(folder, "plain", "rolled", capsys)
    before, after = (robolaser.load_calibration(folder / name) for name in ("plain", "rolled"))
    assert found["theta"]["change"] == pytest.approx(after.value("theta") - before.value("theta"))
    assert found["theta"]["unit"] == "rad"
    assert found["rms_m"]["second"] < found["rms_m"]["first"]


def test_what_one_result_does_not_say_is_null(folder, capsys):
    found = rows(folder, "plain", "rolled", capsys)["laser_roll.laser.angle"]
    assert found["first"] is None
    assert found["second"] == pytest.approx(0.05, rel=0.1)
    assert "change" not in found


def test_a_result_beside_itself_does_not_change(folder, capsys):
    found = rows(folder, "why", "why", capsys)
    assert found["verdict"]["first"] == "explained"
    assert found["probability of laser_roll at laser"]["change"] == 0.0
    assert all(row.get("change", 0.0) == 0.0 for row in found.values())


@pytest.mark.parametrize(
    ("effects", "lacks"), [("", "effects"), (', "effects": [{"effect": "laser_roll"}]', "[[effects]] where, entry 1")]
)
def test_a_damaged_result_is_refused_in_a_sentence(folder, tmp_path, capsys, effects, lacks):
    (tmp_path / "diagnosis.json").write_text(f'{{"format": "robolaser-diagnosis/1"{effects}}}')
    assert main(["diff", str(tmp_path), str(folder / "why")]) == 1
    assert f"diagnosis.json lacks {lacks}: expected" in capsys.readouterr().err


def test_people_see_a_table(folder, capsys):
    assert main(["diff", str(folder / "plain"), str(folder / "rolled")]) == 0
    out = capsys.readouterr().out
    assert "changed by more than 3 standard errors" in out
    (theta,) = (line for line in out.splitlines() if line.split()[:1] == ["theta"])
    assert theta.count("°") == len(("first", "second", "change"))


def test_a_result_in_the_current_folder_has_the_folders_name(folder, monkeypatch, capsys):
    monkeypatch.chdir(folder / "plain")
    assert main(["diff", ".", "../rolled"]) == 0
    assert "plain beside rolled" in capsys.readouterr().out


def test_the_page_is_written_where_it_was_asked_for(folder, tmp_path):
    out = tmp_path / "moved"
    asked = ["diff", str(folder / "plain"), str(folder / "rolled"), "--output", str(out), "--quiet"]
    assert main(asked) == 0
    assert "laser_roll.laser.angle" in (out / "report.html").read_text(encoding="utf-8")
    assert json.loads((out / "diff.json").read_text(encoding="utf-8"))["format"] == "robolaser-diff/1"
    assert main(asked) != 0  # an earlier result is not overwritten


def test_results_in_python_are_compared_as_their_files_are(folder, tmp_path, capsys):
    before, after = (robolaser.load_calibration(folder / name) for name in ("plain", "rolled"))
    compared = before.compare(after)
    found = {row["name"]: row for row in compared["rows"]}
    assert found["theta"] == rows(folder, "plain", "rolled", capsys)["theta"]
    assert "changed by more than 3 standard errors" in repr(compared)
    compared.report(tmp_path / "page.html")
    assert "changed by more than 3 standard errors" in (tmp_path / "page.html").read_text(encoding="utf-8")


@pytest.mark.parametrize(("second", "said"), [("why", "one kind"), ("nowhere", "nowhere")])
def test_what_cannot_be_compared_is_said(folder, second, said, capsys):
    assert main(["diff", str(folder / "plain"), str(folder / second)]) != 0
    told = capsys.readouterr().err
    assert said in told
    assert "Traceback" not in told


def test_a_moving_arms_diagnosis_is_of_another_kind_than_one_of_poses(folder, tmp_path, capsys):
    moving = '{"format": "robolaser-diagnosis/1", "kind": "motion", "verdict": "no_gap", "effects": []}'
    (tmp_path / "diagnosis.json").write_text(moving)
    assert main(["diff", str(folder / "why"), str(tmp_path)]) == 2
    assert "diagnosis/1 of a moving arm: compare results of one kind" in capsys.readouterr().err


def test_a_probability_that_falls_is_shown_with_its_fall(tmp_path, capsys):
    for name, probability in (("before", 0.9), ("after", 0.2)):
        found = {"effect": "laser_roll", "where": "laser", "parameters": {}, "probability": probability}
        (tmp_path / f"{name}.json").write_text(
            json.dumps({"format": "robolaser-diagnosis/1", "dataset": "cell", "effects": [found]})
        )
    assert main(["diff", str(tmp_path / "before.json"), str(tmp_path / "after.json")]) == 0
    assert "90 % 20 % -70 %" in " ".join(capsys.readouterr().out.split())


def test_results_without_their_urdf_are_compared_by_their_numbers(folder, tmp_path, capsys):
    for name in ("plain", "rolled"):
        (tmp_path / name).mkdir()
        (tmp_path / name / "calibration.json").write_bytes((folder / name / "calibration.json").read_bytes())
    assert rows(tmp_path, "plain", "rolled", capsys)["theta"] == rows(folder, "plain", "rolled", capsys)["theta"]


def test_results_of_different_data_are_said_to_be(folder, capsys):
    data = simulate(find_robot("scorbot_er7"), poses=25, points=6, seed=2).dataset  # as many poses, and the name
    robolaser.calibrate(data).save(folder / "plain-later")
    robolaser.diagnose(data, effects=[], seed=0).save(folder / "why-later")
    for first, second in (("plain", "rolled"), ("why", "why")):
        for other, is_said in ((second, False), (f"{first}-later", True)):
            assert main(["diff", str(folder / first), str(folder / other)]) == 0
            assert ("The results are of different data" in " ".join(capsys.readouterr().out.split())) == is_said
