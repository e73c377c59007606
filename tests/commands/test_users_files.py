"""No command replaces or deletes what is not its own earlier result, with --force or without."""

import hashlib
import shutil
from pathlib import Path

import pytest
from few_files import only

from robolaser import compare
from robolaser.cli import main

ETNA = Path(__file__).parents[2] / "examples" / "etna-s2"


def digests(folder):
    return {file.name: hashlib.sha256(file.read_bytes()).hexdigest() for file in folder.iterdir() if file.is_file()}


@pytest.fixture(scope="module")
def made(tmp_path_factory):
    folder = tmp_path_factory.mktemp("made") / "stripe"
    typed = ["simulate", "--robot", "scorbot_er7", "--output", str(folder), "--poses", "12", "--points", "5", "--quiet"]
    assert main(typed) == 0
    return folder


@pytest.fixture
def dataset(made, tmp_path):
    shutil.copytree(made, tmp_path / "stripe")
    return tmp_path / "stripe"


@pytest.mark.parametrize("command", ["calibrate", "diagnose"])
@pytest.mark.parametrize("force", [[], ["--force"]])
def test_a_result_is_never_written_into_the_data_set(dataset, command, force, capsys):
    before = digests(dataset)
    assert main([command, str(dataset), "--output", str(dataset), *force]) == 1
    assert "an input of this command" in capsys.readouterr().err
    assert digests(dataset) == before


@pytest.mark.parametrize(
    ("command", "name"),
    [("diagnose", "robot.urdf"), *(("calibrate", name) for name in ("report.html", "camera.yaml", "search.json"))],
)
def test_the_users_own_files_in_the_folder_of_the_result_stay(dataset, tmp_path, command, name, capsys):
    there = tmp_path / "there"
    there.mkdir()
    (there / name).write_text("mine")
    assert main([command, str(dataset), "--output", str(there), "--force"]) == 1
    assert name in capsys.readouterr().err
    assert digests(there) == {name: hashlib.sha256(b"mine").hexdigest()}


def test_a_copy_of_a_users_robot_replaces_neither_it_nor_the_result_nor_any_other_file(dataset, tmp_path, capsys):
    result = tmp_path / "result"
    with only("robot_corrected.urdf"):
        typed = ["calibrate", str(dataset), "--with", "joint_offset:joint_3", "--output", str(result), "--quiet"]
        assert main(typed) == 0
    mine = tmp_path / "mine.urdf"
    shutil.copy(dataset / "robot.urdf", mine)
    before = [digests(folder) for folder in (tmp_path, dataset, result)]
    for taken in (mine, result / "robot.urdf", result / "new.urdf", dataset / "poses.csv"):
        assert main(["export", str(result), "--into", str(mine), "--output", str(taken), "--force"]) == 1
        assert "Choose another --output" in capsys.readouterr().err
    assert [digests(folder) for folder in (tmp_path, dataset, result)] == before
    own = ["export", str(result), "--into", str(mine), "--output", str(tmp_path / "copies" / "new.urdf"), "--quiet"]
    assert [main(own), main(own), main([*own, "--force"])] == [0, 1, 0]


def test_simulate_does_not_replace_the_urdf_it_was_given(made, tmp_path, capsys):
    urdf = tmp_path / "robot.urdf"
    shutil.copy(made / "robot.urdf", urdf)
    urdf.write_text(urdf.read_text() + "<!-- mine -->\n")
    before = digests(tmp_path)
    assert main(["simulate", "--robot", str(urdf), "--output", str(tmp_path), "--poses", "8", "--force"]) == 1
    assert "robot.urdf" in capsys.readouterr().err
    assert digests(tmp_path) == before


@pytest.mark.parametrize(
    ("typed", "output"),
    [
        (["simulate", "--robot", "stripe/robot.urdf", "--force"], ["--output", "stripe"]),
        (["extract", "recording"], ["--output", "recording/measured"]),
        (["challenge", "new", "--like", "stripe", "--truth", "truth"], ["stripe/trial"]),
    ],
)
def test_nothing_is_written_over_or_into_what_a_command_reads(typed, output, dataset, monkeypatch, capsys):
    monkeypatch.chdir(dataset.parent)
    shutil.copytree(ETNA, "recording")
    before = [*dataset.parent.rglob("*")]
    assert main([*typed, *output]) == 1
    assert "is an input of this command or is inside one" in capsys.readouterr().err
    assert [*dataset.parent.rglob("*")] == before


def test_no_table_of_a_second_sensor_replaces_the_users_own(tmp_path):
    (tmp_path / "corners.csv").write_text("mine")
    typed = ["simulate", "--robot", "scorbot_er7", "--sensor", "stripe+camera", "--poses", "4", "--force"]
    assert main([*typed, "--output", str(tmp_path)]) == 1
    assert digests(tmp_path) == {"corners.csv": hashlib.sha256(b"mine").hexdigest()}


def test_its_own_earlier_result_is_replaced_and_the_rest_of_the_folder_stays(dataset, tmp_path):
    there = tmp_path / "there"
    typed = ["calibrate", str(dataset), "--algorithm", "gauss-newton", "--output", str(there), "--quiet"]
    assert main(typed) == 0
    (there / "notes.txt").write_text("mine")
    first = digests(there)
    assert main(typed) == 1
    assert digests(there) == first
    assert main([*typed, "--force", "--weights", "noise"]) == 0
    second = digests(there)
    assert second["notes.txt"] == first["notes.txt"]
    assert second["calibration.json"] != first["calibration.json"]


def test_the_second_of_two_comparisons_on_one_folder_is_refused_and_the_first_loses_nothing(tmp_path, capsys):
    folder = tmp_path / "cmp"
    again = ["compare", "pymoo:sphere-3", "--output", str(folder), "--algorithms", "ga", "--jobs", "1", "--force"]
    refused = []

    def meanwhile(*_):
        there = (folder / "runs.jsonl").read_bytes()
        assert main([*again, "--seeds", "2", "--seed", "100", "--budget", "100"]) == 1
        refused.append("Another robolaser command" in capsys.readouterr().err)
        assert (folder / "runs.jsonl").read_bytes() == there

    first = compare(["pymoo:sphere-3"], ["ga"], seeds=2, budget=200, jobs=1, output=folder, progress=meanwhile)
    assert refused
    assert all(refused)
    assert first.to_frame()["state"].tolist() == ["done", "done"]
    assert {row.split(",")[2] for row in (folder / "runs.csv").read_text().splitlines()[1:]} == {"1", "2"}
