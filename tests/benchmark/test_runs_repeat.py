"""Each run starts from the same problem; results are written as they come, resumed, loaded, saved and merged."""

import json
import math
import shutil
from pathlib import Path

import pytest
from made_up import outcomes
from mine import Noisy, Sphere
from pymoo.algorithms.soo.nonconvex.ga import GA

import robolaser
from robolaser import load_comparison
from robolaser.cli import main
from robolaser.errors import BenchmarkError, Interrupted, OutputError, UsageError
from robolaser.problems.calibration_suite import DATA

ASKED = {"seeds": 3, "budget": 100}


def test_a_problem_with_state_gives_every_run_the_same_start():
    one, two = (robolaser.compare([Noisy()], ["random", "de"], jobs=jobs, **ASKED) for jobs in (1, 2))
    assert outcomes(one) == outcomes(two)


def test_a_problem_that_is_another_one_in_each_process_is_noticed():
    result = robolaser.compare(["mine:Elsewhere"], ["random"], **ASKED)
    assert {run.state for run in result.runs} == {"failed"}
    assert "the problem is another one" in result.runs[0].reason


def test_two_instances_of_a_class_have_names():
    problems = {"flat": Sphere(n_var=2), "deep": Sphere(n_var=5)}
    result = robolaser.compare(problems, {"small": GA(pop_size=20), "large": GA(pop_size=50)}, **ASKED)
    assert {run.key[:2] for run in result.runs} == {(p, a) for p in problems for a in ("small", "large")}
    with pytest.raises(UsageError, match=r"Name them: .*\"small\""):
        robolaser.compare(["mine:Sphere"], [GA(pop_size=20), GA(pop_size=50)], **ASKED)


def test_what_lies_in_a_script_is_sent_along():
    result = robolaser.compare(
        {"p": Sphere()}, {"by hand": lambda evaluator, seed: evaluator.cost([[1.0, 1.0, 1.0]])}, **ASKED
    )
    assert {(run.state, run.trace.final) for run in result.runs} == {("done", 0.0)}


def test_python_resumes_what_it_began(tmp_path):
    first = robolaser.compare(["mine:Sphere"], ["de"], output=tmp_path, seeds=2, budget=100)
    with pytest.raises(OutputError, match="holds 2 runs"):
        robolaser.compare(["mine:Sphere"], ["de"], output=tmp_path, **ASKED)
    more = robolaser.compare(["mine:Sphere"], ["de"], output=tmp_path, resume=True, **ASKED)
    assert len(more.runs) == 3
    assert outcomes(first).items() < outcomes(more).items()
    assert outcomes(more) == outcomes(robolaser.compare(["mine:Sphere"], ["de"], **ASKED))
    with pytest.raises(BenchmarkError, match="budget is 100 there, here it is 200"):
        robolaser.compare(["mine:Sphere"], ["de"], output=tmp_path, resume=True, seeds=3, budget=200)
    robolaser.compare({"p": "mine:Sphere"}, ["de"], output=tmp_path, resume=True, **ASKED)
    with pytest.raises(BenchmarkError, match="the problem p is another one"):
        robolaser.compare({"p": "mine:Sphere:offset=1"}, ["de"], output=tmp_path, resume=True, **ASKED)


def test_a_line_that_was_cut_off_is_made_again(tmp_path):
    whole = robolaser.compare(["mine:Sphere"], ["de"], output=tmp_path, **ASKED)
    journal = tmp_path / "runs.jsonl"
    journal.write_text(journal.read_text()[:-40])
    assert len(load_comparison(tmp_path).runs) == 2
    assert outcomes(robolaser.compare(["mine:Sphere"], ["de"], output=tmp_path, resume=True, **ASKED)) == outcomes(
        whole
    )


def test_what_is_saved_is_loaded_and_saved_again(tmp_path):
    result = robolaser.compare(["mine:Sphere", "pymoo:zdt1"], ["random"], seeds=2, budget=50)
    result.save(tmp_path / "one")
    again = load_comparison(tmp_path / "one")
    again.save(tmp_path / "two")
    third = load_comparison(tmp_path / "two")
    assert outcomes(third) == outcomes(result)
    assert third.to_dict() == again.to_dict()
    assert {file.name for file in (tmp_path / "two").iterdir()} >= {
        "runs.jsonl", "runs.csv", "comparison.json", "report.html",
    }  # fmt: skip


def test_folders_of_an_array_job_merge(tmp_path, capsys):
    for seed in (1, 2, 3):
        robolaser.compare(
            ["mine:Sphere"], ["de", "random"], seeds=1, first_seed=seed, budget=100, output=tmp_path / f"{seed}"
        )
    folders = [str(tmp_path / f"{seed}") for seed in (1, 2, 3)]
    assert outcomes(load_comparison(*folders)) == outcomes(
        robolaser.compare(["mine:Sphere"], ["de", "random"], **ASKED)
    )
    assert main(["compare", "--merge", *folders, "--output", str(tmp_path / "all")]) == 0
    assert json.loads((tmp_path / "all" / "comparison.json").read_text())["runs"] == {
        "wanted": 6,
        "made": 6,
        "failed": 0,
    }
    assert outcomes(load_comparison(tmp_path / "all")) == outcomes(load_comparison(*folders))


def test_a_merge_is_extended_by_further_folders(tmp_path):
    asked = {"seeds": 1, "budget": 100}
    for seed in (1, 2):
        robolaser.compare("mine:Sphere", "random", first_seed=seed, output=tmp_path / f"{seed}", **asked)
    for seed, more in ((1, []), (2, ["--resume"])):
        merged = ["compare", "--merge", str(tmp_path / f"{seed}"), "--output", str(tmp_path / "all"), *more]
        assert main(merged) == 0
    assert len(load_comparison(tmp_path / "all").runs) == 2


def test_a_merge_replaces_no_comparison_that_it_merges(tmp_path, capsys):
    robolaser.compare("mine:Sphere", "random", output=tmp_path, **ASKED)
    before = (tmp_path / "runs.jsonl").read_bytes()
    assert main(["compare", "--merge", str(tmp_path), "--output", str(tmp_path), "--force"]) == 1
    assert "is an input of this command" in capsys.readouterr().err
    assert (tmp_path / "runs.jsonl").read_bytes() == before


def stopped(*_, **__):
    raise KeyboardInterrupt


def test_runs_are_replaced_only_once_others_can_be_made(tmp_path, monkeypatch):
    robolaser.compare("mine:Sphere", "random", output=tmp_path, **ASKED)
    with pytest.raises(UsageError, match="jobs is 0"):
        robolaser.compare("mine:Sphere", "random", output=tmp_path, force=True, jobs=0, **ASKED)
    with monkeypatch.context() as patch:
        patch.setattr("robolaser.benchmark.compare.engine_of", stopped)
        with pytest.raises(Interrupted, match=r"Stopped, after 0 of 3 runs\.$"):
            robolaser.compare("mine:Sphere", "random", output=tmp_path, force=True, **ASKED)
    assert len(load_comparison(tmp_path).runs) == 3
    robolaser.compare("mine:Sphere", "random", output=tmp_path, force=True, seeds=1, budget=100)
    assert len(load_comparison(tmp_path).runs) == 1


@pytest.mark.parametrize("kind", [str, Path])
def test_nothing_is_written_into_a_data_set_that_is_compared_on(tmp_path, kind):
    data = shutil.copytree(DATA / "lee2004", tmp_path / "data")
    with pytest.raises(OutputError, match="is an input"):
        robolaser.compare([kind(data)], ["random"], output=data / "result", **ASKED)


@pytest.mark.parametrize(
    "limit", [{"time_limit_s": math.inf}, {"target": math.inf}, {"budget": "1e400"}, {"jobs": 0}, {"jobs": -1}]
)
def test_limits_without_a_meaning_are_refused(limit):
    with pytest.raises(UsageError, match=f"{next(iter(limit))} is"):
        robolaser.compare(["mine:Sphere"], ["random"], **{**ASKED, **limit})


def test_instances_are_repetitions_of_one_problem():
    pytest.importorskip("ioh")
    result = robolaser.compare(["bbob:3-2:instance=1..3"], ["random"], **ASKED)
    assert [problem.name for problem in result.problems] == ["bbob:3-2"]
    assert len({run.trace.final for run in result.runs}) == 3


@pytest.mark.parametrize("other", ["random", "de:pop_size=20"])
def test_runs_of_another_algorithm_are_not_those_of_one_that_has_its_name(tmp_path, other):
    asked = {"output": tmp_path, "seeds": 1, "budget": 100}
    robolaser.compare(["mine:Sphere"], {"mine": "de:pop_size=30"}, **asked)
    with pytest.raises(BenchmarkError, match="the algorithm mine is"):
        robolaser.compare(["mine:Sphere"], {"mine": other}, resume=True, **asked)
    assert len(robolaser.compare(["mine:Sphere"], {"mine": "de:pop_size=30"}, resume=True, **asked).runs) == 1


def test_a_journal_without_its_first_line_is_refused(tmp_path):
    robolaser.compare(["mine:Sphere"], ["random"], output=tmp_path, seeds=1, budget=100)
    journal = tmp_path / "runs.jsonl"
    journal.write_text("".join(journal.read_text().splitlines(keepends=True)[1:]))
    with pytest.raises(BenchmarkError, match="cannot be read as the runs of a comparison"):
        load_comparison(tmp_path)
