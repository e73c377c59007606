"""What every command keeps to: exit codes, one-line messages, results that are never lost."""

import errno
import json
import os
import signal
import subprocess
import sys
from importlib.resources import files
from pathlib import Path
from typing import Any

import jsonschema
import pytest

from robolaser.calibration import pymoo_search
from robolaser.cli import app, main
from robolaser.data.result_folder import MANIFEST
from robolaser.problems.calibration_suite import DATA

GROUPS = ("challenge", "new")
SIMULATED = ["simulate", "--robot", "scorbot_er7", "--poses", "5", "--points", "5", "--seed", "3"]


@pytest.fixture(params=[name for name in app if not name.startswith("-")])
def command(request: pytest.FixtureRequest) -> str:
    name: str = request.param
    return name


@pytest.fixture(scope="module")
def dataset(tmp_path_factory: pytest.TempPathFactory) -> Path:
    folder = tmp_path_factory.mktemp("cli") / "paper"
    assert main([*SIMULATED, "--output", str(folder)]) == 0
    return folder


@pytest.fixture(scope="module")
def result(dataset: Path, tmp_path_factory: pytest.TempPathFactory) -> Path:
    out = tmp_path_factory.mktemp("cli") / "deep" / "result"
    assert main(["calibrate", str(dataset), "--output", str(out)]) == 0
    return out


@pytest.mark.parametrize(
    "words",
    [[name] for name in app if name[0].isalpha() and name not in GROUPS]
    + [["challenge", "new"], ["challenge", "score"], ["new", "cell"]],
)
def test_every_command_has_json_quiet_and_an_example(words, capsys):
    assert main([*words, "--help"]) == 0
    said = capsys.readouterr().out
    assert "--json   " in said
    assert "--quiet  Print warnings and errors only." in said
    assert f"    robolaser {' '.join(words)} " in said


def test_wrong_usage_exits_with_two(command, capsys):
    assert main([command, "--no-such-option"]) == 2
    said = capsys.readouterr()
    assert said.out == ""
    assert said.err.startswith("robolaser: ")
    assert said.err.count("\n") == 1


@pytest.mark.parametrize(("words", "what"), [([], "DATASET"), (["log"], "--output"), (["log", "--output"], "--output")])
def test_what_is_missing_is_named(words, what, capsys):
    assert main(["calibrate", *words]) == 2
    assert capsys.readouterr().err.startswith(f"robolaser: The value of {what} is missing. See")


@pytest.mark.parametrize("words", [["--output", ""], ["--output="]])
def test_an_empty_path_is_not_the_current_folder(words, tmp_path, monkeypatch, capsys):
    monkeypatch.chdir(tmp_path)
    assert main([*SIMULATED, *words]) == 2
    assert capsys.readouterr().err.startswith(f"robolaser: The value after {words[0]} is empty.")
    assert not list(tmp_path.iterdir())


@pytest.mark.parametrize("words", [[], *([name] for name in GROUPS)])
def test_no_command_is_wrong_usage(words, capsys):
    assert main(words) == 2
    said = capsys.readouterr()
    assert said.out == ""
    assert "--help" in said.err


@pytest.mark.parametrize(
    ("words", "meant"),
    [
        (["calibrat", "here"], '"calibrate"'),
        (["calibrate", "here", "--output", "there", "--sed", "3"], "--seed"),
        (["calibrate", "here", "--output", "there", "--weights", "nois"], '"noise"'),
        (["simulate", "--robot", "scorbot_er", "--output", "there"], "'scorbot_er7'"),
        (["simulate", "--robot", "scorbot_er7", "--output", "there", "--effect", "laser_rol=1"], "'laser_roll'"),
    ],
)
def test_a_slip_is_answered_with_what_was_meant(words, meant, tmp_path, monkeypatch, capsys):
    monkeypatch.chdir(tmp_path)
    assert main(words) == 2
    assert f"Did you mean {meant}" in capsys.readouterr().err


@pytest.mark.parametrize(
    ("words", "said"),
    [
        ("simulate --robot ur5e --sensor motion --output out --poses 9", "leave out --poses"),
        ("simulate --robot ur5e --sensor motion --output out --joint-rad 1", "leave out the noise"),
        ("simulate --robot ur5e --sensor point --output out --poses 5 --mount base", "leave out --mount"),
        ("plan DATASET --mount base", "leave out --mount"),
        ("plan DATASET --points 3", "leave out --points"),
        ("plan DATASET/poses.csv --robot scorbot_er7 --sensor point --mount base --point-m 1e-4", "leave out --mount"),
        ("compare --merge one --output out --seeds 3", "leave out --seeds"),
        ("challenge new out --like DATASET --poses 9", "leave out --poses"),
        ("import log.csv --output out --dh modified", "--dh modified: of which robot"),
        ("import log.csv --output out --xacro-arg a=b", "--xacro-arg a=b: of which robot"),
    ],
)
def test_an_option_that_would_do_nothing_is_refused(dataset, words, said, capsys):
    assert main([word.replace("DATASET", str(dataset)) for word in words.split()]) == 2
    assert said in capsys.readouterr().err


def test_noise_that_a_sensor_does_not_have_is_warned_of(dataset, capsys):
    assert main(["plan", str(dataset), "--point-m", "1", "--quiet"]) == 0
    said = "A laser stripe scanner has no such noise, so it is not used: --point-m"
    assert said in capsys.readouterr().err


def test_a_size_where_an_effect_is_only_named_is_answered_with_its_name(dataset, tmp_path, capsys):
    assert main(["calibrate", str(dataset), "--output", str(tmp_path / "out"), "--with", "laser_roll=0.1"]) == 2
    assert "'laser_roll=0.1' states a size" in capsys.readouterr().err
    assert not (tmp_path / "out" / "calibration.json").exists()


@pytest.mark.parametrize("words", [["list", "sensors"], ["list", "robots"], [*SIMULATED, "--output", "cell"]])
def test_json_is_all_that_standard_output_holds(words, tmp_path, monkeypatch, capsys):
    monkeypatch.chdir(tmp_path)
    assert main([*words, "--json"]) == 0
    assert json.loads(capsys.readouterr().out)


def test_a_calibration_as_json_is_what_is_written_and_a_quiet_one_says_nothing(dataset, tmp_path, capsys):
    run = ["calibrate", str(dataset), "--algorithm", "gauss-newton", "--output"]
    assert main([*run, str(tmp_path / "a"), "--json"]) == 0
    assert capsys.readouterr().out == (tmp_path / "a" / "calibration.json").read_text(encoding="utf-8")
    assert main([*run, str(tmp_path / "b"), "--quiet"]) == 0
    assert capsys.readouterr().out == ""
    assert (tmp_path / "b" / "calibration.json").exists()


@pytest.mark.parametrize("family", ["robots", "effects", "algorithms", "sensors"])
def test_list_shows_one_line_each(family, capsys):
    assert main(["list", family]) == 0
    lines = capsys.readouterr().out.splitlines()
    assert len(lines) >= 3
    assert all(line == line.rstrip() for line in lines)


def test_the_result_is_what_its_schema_says(result):
    schema = json.loads(files("robolaser").joinpath("schemas/calibration.schema.json").read_text())
    found = json.loads((result / "calibration.json").read_text())
    jsonschema.Draft202012Validator.check_schema(schema)
    jsonschema.validate(found, schema)
    assert list(found["parameters"])[:8] == ["f", "s_u", "s_v", "u_0", "v_0", "k", "b", "theta"]
    assert found["parameters"]["f"]["std"] is None
    assert found["rms_m"] == pytest.approx((found["objective_m2"] / 25) ** 0.5)


def test_every_promised_file_is_there_and_no_state_is_left(result):
    there = {path.name for path in result.iterdir()}
    assert there == {
        "calibration.json", "report.html", "robot.urdf", "camera.yaml", "robot_corrected.xml", "corrected.py",
        "robot_corrected.sdf", "static_transform.sh", MANIFEST,
    }  # fmt: skip


def test_a_file_where_the_output_folder_should_be_is_said(dataset, tmp_path, capsys):
    (tmp_path / "taken").write_text("mine")
    assert main(["calibrate", str(dataset), "--output", str(tmp_path / "taken")]) == 1
    assert "taken" in capsys.readouterr().err
    assert (tmp_path / "taken").read_text() == "mine"


@pytest.mark.parametrize(
    ("words", "expected"),
    [
        (["calibrate", "DATASET", "--with", "laser_rol"], "Did you mean 'laser_roll'"),
        (["calibrate", "DATASET", "--with", "joint_offset:joint_9"], "There are: joint_1"),
        (["calibrate", "DATASET", "--algorithm", "rgca"], "Did you mean 'rcga'"),
        (["diagnose", "DATASET", "--without", "laser_rol"], "Did you mean 'laser_roll'"),
        (["diagnose", "DATASET", "--without", "joint_offset:nowhere"], "Did you mean 'joint_offset'"),
        (["simulate", "--robot", "scorbot_er7", "--effect", "joint_offset:nowhere=0.01"], "There are: joint_1"),
        (["calibrate", "DATASET", "--with", "outliers"], "outliers cannot be added to a model"),
        (["diagnose", "DATASET", "--without", "gravity_direction"], "every diagnosis looks for it"),
        (["simulate", "--robot", "scorbot_er7", "--effect", "mispaired=1"], "cannot be added to a model"),
    ],
)
def test_an_unknown_effect_location_or_algorithm_is_wrong_usage_and_gets_the_near_ones(
    dataset, tmp_path, words, expected, capsys
):
    words = [str(dataset) if word == "DATASET" else word for word in words]
    assert main([*words, "--output", str(tmp_path / "out")]) == 2
    assert expected in capsys.readouterr().err


@pytest.mark.parametrize("option", ["--seed", "--poses"])
def test_a_number_that_is_not_whole_is_not_rounded(option, tmp_path, capsys):
    assert main(["simulate", "--robot", "scorbot_er7", "--output", str(tmp_path / "out"), option, "1.5"]) == 2
    assert f"Invalid value for {option}: '1.5' is no whole number." in capsys.readouterr().err


@pytest.mark.parametrize("stream", ["closed", "full", "ascii"])
def test_whatever_the_output_is_nobody_sees_a_traceback(stream):
    how = {"closed": ">&-", "full": ">/dev/full", "ascii": "| cat"}[stream]
    if stream == "full" and not Path("/dev/full").exists():
        pytest.skip("no /dev/full here")
    code = "import sys; from robolaser.cli import main; sys.exit(main(['list', 'effects']))"
    said = subprocess.run(
        ["sh", "-c", f'"{sys.executable}" -c "{code}" {how}'], capture_output=True, text=True, check=False,
        env={**os.environ, "PYTHONIOENCODING": "ascii"},
    )  # fmt: skip
    assert "Traceback" not in said.stderr
    assert said.returncode == (1 if stream == "full" else 0)


def test_a_folder_that_must_not_be_looked_into_is_said(dataset, tmp_path, monkeypatch, capsys):
    def refuse(folder: Path) -> None:
        raise PermissionError(errno.EACCES, os.strerror(errno.EACCES), str(folder))

    monkeypatch.setattr("robolaser.api.load_dataset", refuse)
    assert main(["calibrate", str(dataset), "--output", str(tmp_path / "out")]) == 1
    said = capsys.readouterr().err
    assert "Permission denied" in said
    assert said.count("\n") == 1


def test_points_that_are_there_are_not_overwritten_by_extract(dataset, capsys):
    assert main(["extract", str(dataset)]) == 1
    assert "points.csv" in capsys.readouterr().err


def test_a_data_set_without_images_cannot_be_extracted_from(dataset, tmp_path, capsys):
    assert main(["extract", str(dataset), "--output", str(tmp_path / "out")]) == 1
    assert "[board]" in capsys.readouterr().err


def test_ctrl_c_leaves_a_state_that_resume_goes_on_from(dataset, tmp_path, monkeypatch, capsys):
    out = tmp_path / "out"
    whole = ["calibrate", str(dataset), "--algorithm", "rcga", "--generations", "40", "--no-polish"]
    save_state = pymoo_search.save_state

    def interrupted(*state: Any) -> None:
        save_state(*state)
        signal.raise_signal(signal.SIGINT)

    with monkeypatch.context() as patch:
        patch.setattr(pymoo_search, "SECONDS_BETWEEN_CHECKPOINTS", 0.0)
        patch.setattr(pymoo_search, "save_state", interrupted)
        assert main([*whole, "--output", str(out)]) == 1
    said = capsys.readouterr().err
    assert "--resume" in said
    assert "Traceback" not in said
    assert main([*whole, "--output", str(out)]) == 1  # neither resumed nor forced: the state is kept
    history = (out / "search.json").read_bytes()
    (out / "search.json").write_bytes(history[: len(history) // 2])
    assert main([*whole, "--output", str(out), "--resume"]) == 1
    (out / "search.json").write_bytes(history)
    assert main([*whole, "--output", str(out), "--resume"]) == 0
    assert main([*whole, "--output", str(tmp_path / "straight")]) == 0
    resumed, straight = (json.loads((d / "calibration.json").read_text()) for d in (out, tmp_path / "straight"))
    assert resumed["parameters"] == straight["parameters"]


def test_generations_of_a_search_that_has_none_are_pointed_out(dataset, tmp_path, capsys):
    assert main(["calibrate", str(dataset), "--generations", "9", "--resume", "--output", str(tmp_path / "out")]) == 0
    told = capsys.readouterr().err
    assert "--generations has no effect" in told
    assert "--resume has no effect" in told


def test_importing_the_package_loads_no_physics():
    heavy = "{'numpy', 'numba', 'pymoo', 'pinocchio', 'cv2', 'scipy', 'rich.progress'}"
    code = (
        "import sys, robolaser, robolaser.cli\n"
        "robolaser.cli.app.parse_args(['list', 'robots'])\n"
        f"print(sorted({heavy} & set(sys.modules)))"
    )
    said = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True).stdout
    assert said.strip() == "[]"


def test_a_real_laser_that_is_rolled_leaves_the_papers_model_an_error_five_times_as_large(tmp_path):
    run = ["calibrate", str(DATA / "etna-s2"), "--algorithm", "gauss-newton"]
    assert main([*run, "--with", "laser_roll", "--output", str(tmp_path / "roll")]) == 0
    assert main([*run, "--output", str(tmp_path / "paper")]) == 0
    roll, paper = (json.loads((tmp_path / d / "calibration.json").read_text()) for d in ("roll", "paper"))
    assert roll["held_out_rms_m"] < 5e-4
    assert paper["held_out_rms_m"] > 5 * roll["held_out_rms_m"]
