"""`robolaser compare` as its user meets it."""

import csv
import json
import os
import signal
import subprocess
import sys
import time
from importlib.resources import files
from pathlib import Path

import jsonschema
import pytest
from made_up import outcomes

from robolaser import load_comparison
from robolaser.cli import main
from robolaser.errors import BenchmarkError, OutputError

HERE = Path(__file__).parent
ALGORITHMS = "rcga,random,mine:halving,mine:raising,mine:not_a_number,least-squares"
ASKED = ["compare", "paper", "pymoo:sphere-3", "--algorithms", ALGORITHMS, "--seeds", "2", "--budget", "500"]


@pytest.fixture(scope="module")
def at_home():
    before = Path.cwd()
    os.chdir(HERE)
    yield
    os.chdir(before)


@pytest.fixture(scope="module")
def result(at_home, tmp_path_factory) -> Path:
    folder = tmp_path_factory.mktemp("compared") / "result"
    assert main([*ASKED, "--output", str(folder), "--jobs", "2", *["--iohprofiler", "--latex"]]) == 0
    return folder


def said(folder: Path) -> dict:
    return json.loads((folder / "comparison.json").read_text())


def test_the_result_is_what_its_schema_says(result):
    schema = json.loads(files("robolaser").joinpath("schemas/comparison.schema.json").read_text())
    jsonschema.Draft202012Validator.check_schema(schema)
    jsonschema.validate(said(result), schema)


def test_every_run_and_target_has_a_row(result):
    rows = list(csv.DictReader((result / "runs.csv").read_text().splitlines()))
    runs = load_comparison(result).runs
    assert len(rows) == sum(21 if run.problem == "paper" else 51 for run in runs)
    assert len(runs) == said(result)["runs"]["made"]
    for row in rows:
        assert (row["reached"] == "yes") == bool(row["evaluations"]) == bool(row["seconds"])
        if row["reached"] == "yes":
            assert float(row["run_best"]) <= float(row["target"])


def test_failures_are_named_with_their_reasons_and_the_others_go_on(result):
    reasons = {(one["algorithm"], one["seed"]): one["reason"] for one in said(result)["failures"]}
    assert reasons["mine:raising", 1] == "RuntimeError: out of ideas"
    assert "is not a number" in reasons["mine:not_a_number", 2]
    assert {algorithm for algorithm, _ in reasons} == {"mine:raising", "mine:not_a_number"}


def test_who_has_nothing_to_say_on_a_problem_is_named_with_the_reason(result):
    (refused,) = said(result)["refused"]
    assert (refused["problem"], refused["algorithm"]) == ("pymoo:sphere-3", "least-squares")
    assert "not a sum of squares" in refused["reason"]


def test_the_runs_are_written_for_iohprofiler_too(result):
    assert len(list((result / "iohprofiler").glob("*/*.json"))) == 11


def test_the_tables_for_a_paper_name_every_algorithm(result):
    text = (result / "tables.tex").read_text()
    assert all(name.replace("_", r"\_") in text for name in ALGORITHMS.split(","))


def test_exports_of_an_earlier_result_are_not_left_beside_a_new_one(at_home, tmp_path):
    few = ["compare", "pymoo:sphere-2", "--algorithms", "random", "--seeds", "1", "--budget", "50", "--jobs", "1"]
    assert main([*few, "--output", str(tmp_path), "--iohprofiler", "--latex"]) == 0
    before = {file.name for file in tmp_path.iterdir()}
    assert main([*few, "--output", str(tmp_path), "--force"]) == 0
    assert before - {file.name for file in tmp_path.iterdir()} == {"iohprofiler", "tables.tex"}


def test_one_process_gives_what_two_give_to_the_last_bit(result, at_home, tmp_path):
    assert main([*ASKED, "--output", str(tmp_path), "--jobs", "1"]) == 0
    assert outcomes(load_comparison(tmp_path)) == outcomes(load_comparison(result))


def _has_runs(folder: Path) -> bool:
    try:
        return bool(load_comparison(folder).runs)
    except (BenchmarkError, OutputError):  # not there yet
        return False


@pytest.mark.parametrize("end", [signal.SIGINT, signal.SIGTERM], ids=["Ctrl-C", "a batch system"])
def test_a_comparison_that_is_ended_leaves_a_report_and_says_how_to_go_on(tmp_path, end):
    code = "import sys; from robolaser.cli import main; sys.exit(main(sys.argv[1:]))"
    slow = ["compare", "mine:Slow:seconds=0.02", "--algorithms", "random", "--seeds", "22", "--budget", "30"]
    command = [sys.executable, "-c", code, *slow, "--output", str(tmp_path), "--jobs", "1"]
    process = subprocess.Popen(command, cwd=HERE, stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True)
    until = time.monotonic() + 300
    while time.monotonic() < until and not _has_runs(tmp_path):
        time.sleep(0.05)
    process.send_signal(end)
    shown, complaint = process.communicate(timeout=300)
    assert process.returncode == 1
    assert "of 22 runs so far" in shown
    assert "continue with --resume" in complaint
    assert "Traceback" not in complaint
    stopped = outcomes(load_comparison(tmp_path))
    assert 0 < len(stopped) < 22
    assert said(tmp_path)["runs"]["made"] == len(stopped)
    assert "so far" in (tmp_path / "report.html").read_text()


def test_a_finished_comparison_is_only_shown_again(result, at_home):
    before = outcomes(load_comparison(result))
    good = ["compare", "paper", "--algorithms", "rcga,random", "--seeds", "2", "--budget", "500"]
    assert main([*good, "--output", str(result), "--resume"]) == 0
    assert outcomes(load_comparison(result)) == before
    assert len(load_comparison(result).runs) == 22
    assert said(result)["runs"] == {"wanted": 4, "made": 4, "failed": 0}


@pytest.mark.parametrize(
    ("typed", "complaint"),
    [
        (["paper", "--algorithms", "rgca"], "Did you mean 'rcga'?"),
        (["paper", "--algorithms", "rcga:bb=2"], "bb"),
        (["paper", "--algorithms", "mine:Sphere"], "mine:Sphere is an object of class Sphere and cannot search"),
        (["mine:Sphere", "--algorithms", "GA:crossover=ArithmeticCrossover:crossover.prob=2"], "prob is 2, expected"),
        (["paper", "--algorithms", "rcga,,de"], "a name is missing"),
        (["papre"], "No folder 'papre'"),
        (["pymoo:rastrigen"], "Did you mean 'pymoo:rastrigin'?"),
        (["a", "--merge", "--target", "0.1"], "--merge makes no runs"),
        (["paper", "--scheduler", "tcp://127.0.0.1:1", "--jobs", "2"], "--jobs"),
    ],
)
def test_what_has_no_meaning_is_wrong_usage_and_touches_nothing(typed, complaint, tmp_path, capsys):
    assert main(["compare", *typed, "--output", str(tmp_path / "new")]) == 2
    assert complaint in capsys.readouterr().err
    assert not (tmp_path / "new").exists()


@pytest.mark.parametrize("option", ["--seeds=0", "--budget=0", "--time-limit=0", "--target=inf", "--jobs=0"])
def test_limits_of_nothing_are_wrong_usage(option, tmp_path):
    assert main(["compare", "paper", "--output", str(tmp_path), option]) == 2


def test_what_is_no_number_is_told_that_one_is_needed(tmp_path, capsys):
    assert main(["compare", "paper", "--output", str(tmp_path), "--target=nan"]) == 2
    assert "Expected a finite number above 0." in capsys.readouterr().err
