"""A trial from end to end, as typed."""

import json
import shutil
import stat
import sys
from pathlib import Path

import numpy as np
import pytest

from robolaser.cli import main
from robolaser.data.loading import load
from robolaser.data.result_folder import MANIFEST, results_in
from robolaser.errors import TrialError
from robolaser.trials.trial import DIAGNOSIS, SEAL, truth_beside, unseal

KINDS = "none, outliers"
NEW = ("--kinds", KINDS, "--count", "2", "--poses", "8-9", "--points", "4", "--seed", "5")


@pytest.fixture(scope="module")
def made(tmp_path_factory):
    folder = tmp_path_factory.mktemp("made") / "trial"
    assert main(["challenge", "new", str(folder), *NEW]) == 0
    return folder


@pytest.fixture
def trial(made, tmp_path):
    """A copy, with the diagnoses of somebody who is always right."""
    folder = tmp_path / "trial"
    shutil.copytree(made, folder)
    shutil.copytree(truth_beside(made), truth_beside(folder))
    for name, truth in unseal(folder, truth_beside(folder)).items():
        file = folder / name / DIAGNOSIS
        file.parent.mkdir()
        file.write_text(json.dumps(perfect(truth)))
    return folder


def perfect(truth):
    effects = [
        {"effect": e["effect"], "where": e["where"], "probability": 1.0, "parameters": {}, "indistinguishable_from": []}
        for e in truth["each"]
    ]
    gap = dict.fromkeys(("nominal", "calibrated", "after", "noise_floor"), 0.1)
    head = {"format": "robolaser-diagnosis/1", "verdict": "no_gap"}
    return {**head, "gap_mm": gap, "where": [], "effects": effects}


def test_who_is_always_right_scores_everything(trial, capsys):
    assert main(["challenge", "score", str(trial)]) == 0
    scored = json.loads((trial / "score.json").read_text())
    assert scored["groups"]["none"]["share"] == scored["groups"]["outliers"]["share"] == 1.0
    assert len(capsys.readouterr().out.splitlines()) <= 25


def test_no_score_is_written_into_the_truth(trial, capsys):
    assert main(["challenge", "score", str(trial), "--output", str(truth_beside(trial))]) == 1
    assert "is an input of this command" in capsys.readouterr().err


def test_a_data_set_that_nobody_diagnosed_is_diagnosed(trial):
    min(trial.rglob(Path(DIAGNOSIS).name)).unlink()
    assert main(["challenge", "score", str(trial), "--jobs", "1"]) == 0
    assert len(list(trial.rglob(Path(DIAGNOSIS).name))) == 2


def test_diagnoses_that_were_made_before_a_stop_are_said_to_be_there(trial, monkeypatch, capsys):
    def stopped(*_: object, **__: object) -> None:
        raise KeyboardInterrupt

    min(trial.rglob(Path(DIAGNOSIS).name)).unlink()
    monkeypatch.setattr("robolaser.trials.trial.diagnose_missing", stopped)
    assert main(["challenge", "score", str(trial)]) == 1
    assert capsys.readouterr().err == "robolaser: Stopped. 1 of 2 data sets are diagnosed, and stay so.\n"


def test_a_score_that_is_there_stays_unless_forced(trial):
    main(["challenge", "score", str(trial)])
    assert main(["challenge", "score", str(trial)]) == 1
    assert main(["challenge", "score", str(trial), "--force"]) == 0


def test_one_letter_changed_breaks_the_seal(trial):
    seal, truth = trial / "seal.txt", truth_beside(trial)
    text, (kept,) = seal.read_text(), truth.iterdir()
    seal.write_text(text[:-2] + ("0" if text[-2] != "0" else "1") + "\n")
    with pytest.raises(TrialError, match="The maker of the trial has its truth"):
        unseal(trial, truth)
    seal.write_text("sha256 ../../truth\n")
    with pytest.raises(TrialError, match="does not state a SHA-256"):
        unseal(trial, truth)
    seal.write_text(text)
    kept.write_bytes(kept.read_bytes().replace(b"outliers", b"nothing_"))
    with pytest.raises(TrialError, match="does not match the hash"):
        unseal(trial, truth)


def test_the_truth_is_in_a_folder_of_its_own_that_its_maker_alone_reads(trial, tmp_path, capsys):
    truth = truth_beside(trial)
    assert trial not in truth.parents
    assert [stat.S_IMODE(file.stat().st_mode) for file in truth.iterdir()] == [0o600]
    assert main(["challenge", "score", str(trial), "--truth", str(tmp_path / "none")]) == 1
    assert "--truth DIR" in capsys.readouterr().err
    truth.rename(tmp_path / "kept")
    assert main(["challenge", "score", str(trial), "--truth", str(tmp_path / "kept")]) == 0


def test_a_folder_may_hold_the_truths_of_several_trials(made, tmp_path, capsys):
    both = tmp_path / "truths"
    for name, seed in (("one", "5"), ("other", "6")):
        few = ("--kinds", "none", "--count", "1", "--poses", "8", "--points", "4", "--seed", seed)
        assert main(["challenge", "new", str(tmp_path / name), *few, "--truth", str(both)]) == 0
        assert f"score {tmp_path / name} --truth {both}" in capsys.readouterr().out
    assert [unseal(tmp_path / name, both)["world-000"]["kind"] for name in ("one", "other")] == ["none", "none"]


@pytest.mark.parametrize("file", ["points.csv", "poses.csv", "dataset.toml"])
def test_other_data_than_were_made_are_not_scored(trial, file, capsys):
    path = trial / "world-001" / file
    path.write_text(path.read_text() + "\n")
    assert main(["challenge", "score", str(trial)]) == 1
    assert "world-001 holds other data" in capsys.readouterr().err


@pytest.mark.parametrize(
    "text",
    [
        "{",
        "[]",
        "[" * 100_000,
        '{"format": "robolaser-diagnosis/1"}',
        '{"format": "robolaser-diagnosis/1", "verdict": 3, "gap_mm": [], "where": 1, "effects": {"a": 1}}',
        '{"format": "robolaser-diagnosis/1", "verdict": "no_gap", "gap_mm": {}, "where": [], "effects": [1]}',
    ],
)
def test_what_is_no_diagnosis_is_said_in_a_sentence(trial, text, capsys):
    (trial / "world-000" / DIAGNOSIS).write_text(text)
    assert main(["challenge", "score", str(trial)]) == 1
    assert "is not a diagnosis in the format" in capsys.readouterr().err


def test_a_diagnosis_of_the_world_before_is_not_scored_and_somebodys_own_stays(trial, capsys):
    kept = {file: file.read_bytes() for file in trial.rglob("*") if file.is_file()}
    assert main(["challenge", "new", str(trial), *NEW, "--force"]) == 1
    assert "diagnosis.json, but what is there is not its own" in capsys.readouterr().err
    assert {file: file.read_bytes() for file in trial.rglob("*") if file.is_file()} == kept
    names = [str(file.relative_to(trial)) for file in trial.rglob(Path(DIAGNOSIS).name)]
    for name in names:
        (trial / name).unlink()
    with results_in(trial, command="challenge score", files=names):
        for name in names:
            (trial / name).write_bytes(kept[trial / name])
    assert main(["challenge", "new", str(trial), *NEW, "--force"]) == 0
    assert not list(trial.rglob(Path(DIAGNOSIS).name))


def test_a_smaller_trial_leaves_no_world_or_score_of_the_one_before(made, tmp_path, capsys):
    folder = tmp_path / "my trial"
    shutil.copytree(made, folder)
    with results_in(folder, command="challenge score", files=["score.json"]):
        (folder / "score.json").touch()
    assert main(["challenge", "new", str(folder), *NEW[:2], "--count", "1", *NEW[4:], "--force"]) == 0
    assert {file.name for file in folder.iterdir()} == {MANIFEST, SEAL, "world-000"}
    assert f"robolaser challenge score '{folder}'\n" in capsys.readouterr().out


def test_the_same_seed_makes_the_same_trial_to_the_bit(made, tmp_path):
    again = tmp_path / "again"
    main(["challenge", "new", str(again), *NEW])
    for path in made.rglob("*"):
        if path.is_file():
            assert (again / path.relative_to(made)).read_bytes() == path.read_bytes()


@pytest.mark.parametrize(
    ("typed", "code", "message"),
    [
        (("new", "{trial}"), 1, "already"),
        (("new", "{new}", "--kinds", "pear"), 2, "Did you mean 'pair'"),
        (("new", "{new}", "--kinds", "hysteresys"), 2, "Did you mean 'hysteresis'"),
        (("new", "{new}", "--poses", "72-36"), 2, "least before the most"),
        (("new", "{new}", "--points", "0.5"), 2, "whole numbers"),
        (("new", "{new}", "--points", "2", "--poses", "8", "--kinds", "none"), 1, "3 points or more in view"),
        (("new", "{new}", "--truth", "{new}/truth"), 2, "given away with it"),
        (("score", "{new}"), 1, "not a blind trial"),
    ],
)
def test_what_cannot_be_is_said_in_a_sentence(typed, code, message, trial, tmp_path, capsys):
    assert main(["challenge", *[word.format(trial=trial, new=tmp_path / "new") for word in typed]]) == code
    assert message in capsys.readouterr().err


def test_a_cell_without_joints_or_place_cannot_be_imitated(trial, tmp_path, capsys):
    floating = tmp_path / "floating"
    assert main(["simulate", "--robot", "scorbot_er7", "--poses", "5", "--unplaced", "--output", str(floating)]) == 0
    assert main(["challenge", "new", str(tmp_path / "new"), "--like", str(floating)]) == 1
    assert "the pose of its target is unknown" in capsys.readouterr().err


def test_without_mujoco_the_worlds_that_it_moves_are_refused_before_anything_is_made(tmp_path, monkeypatch, capsys):
    monkeypatch.setitem(sys.modules, "mujoco", None)
    assert main(["challenge", "new", str(tmp_path / "new"), "--kinds", "none,soft_base"]) == 1
    assert "pip install 'robolaser[trials]'" in capsys.readouterr().err
    assert not list(tmp_path.rglob("world-*"))


def test_a_trackers_data_set_can_be_imitated(tmp_path):
    measured = tmp_path / "measured"
    simulated = ("--robot", "scorbot_er7", "--sensor", "point", "--poses", "8", "--output", str(measured))
    assert main(["simulate", *simulated]) == 0
    assert (
        main(["challenge", "new", str(tmp_path / "new"), "--like", str(measured), "--count", "1", "--seed", "2"]) == 0
    )
    like, model = load(tmp_path / "new" / "world-000"), load(measured)
    assert like.kind == "point"
    assert like.points.names == model.points.names
    np.testing.assert_allclose(like.poses.q, model.poses.q, atol=1e-8)
    assert np.abs(like.points.xyz - model.points.xyz).max() < 0.1
