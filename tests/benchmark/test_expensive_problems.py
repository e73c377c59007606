"""Expensive problems: nothing is evaluated that does not count, and nothing that was found is lost."""

import time

import pytest
from mine import Slow, Stuck

import robolaser
from robolaser.benchmark.evaluator import RunLimits
from robolaser.benchmark.run import Task
from robolaser.cli import main


def test_a_budget_is_kept_to_the_candidate(tmp_path):
    count = tmp_path / "count"
    result = robolaser.compare([Slow(0.0, str(count))], ["de", "random"], seeds=2, budget=20, jobs=1)
    assert [run.evaluations for run in result.runs] == [20] * 4
    looked_at = 3  # twice when the comparison is planned, once in the process
    assert len(count.read_text()) == 4 * 20 + looked_at


@pytest.mark.parametrize("search", ["liar", "deaf", "deaf_and_astray", "deaf_for_ever"])
def test_who_tampers_with_the_count_or_swallows_the_end_evaluates_exactly_the_budget_and_is_done(
    search, tmp_path, monkeypatch
):
    monkeypatch.setattr("robolaser.benchmark.compare.GRACE_S", 1.0)
    count = tmp_path / "count"
    result = robolaser.compare(
        [Slow(0.0, str(count))], [f"mine:{search}"], seeds=1, budget=20, jobs=1, time_limit_s=1.0
    )
    (run,) = result.runs
    assert (run.state, run.reason, run.evaluations) == ("done", "", 20)
    assert len(run.trace.costs)
    assert len(count.read_text()) == 20 + 3


def test_who_swallows_the_end_of_its_time_evaluates_no_more():
    result = robolaser.compare([Slow(0.1)], ["mine:deaf"], seeds=1, budget=1000, time_limit_s=0.5, jobs=1)
    (run,) = result.runs
    assert (run.state, run.reason) == ("done", "ended by its time limit of 0.5 s")
    assert run.evaluations <= 6


def test_the_time_limit_is_looked_at_after_each_candidate_and_keeps_what_was_found():
    began = time.monotonic()
    (run,) = robolaser.compare([Slow(0.1)], ["GA:pop_size=100"], seeds=1, budget=1000, time_limit_s=0.5).runs
    assert (run.state, run.reason) == ("done", "ended by its time limit of 0.5 s")
    assert 1 <= run.evaluations <= 6  # of a hundred; how many depends on how busy the machine is
    assert run.trace.final < 75
    assert time.monotonic() - began < 60


def test_a_crash_of_a_candidate_may_cost_infinity():
    failing = robolaser.compare(["mine:Flaky"], ["random"], seeds=2, budget=300)
    assert {run.state for run in failing.runs} == {"failed"}
    result = robolaser.compare(["mine:Flaky"], ["random", "de"], seeds=2, budget=300, on_error="inf")
    assert {(run.state, run.evaluations) for run in result.runs} == {("done", 300)}


@pytest.mark.parametrize("algorithm", ["mine:hanging", "mine:dying"])
def test_who_hangs_or_dies_fails_alone_and_keeps_what_it_found(algorithm, monkeypatch):
    monkeypatch.setattr("robolaser.benchmark.compare.GRACE_S", 2.0)
    result = robolaser.compare(["mine:Sphere"], [algorithm, "random"], seeds=1, budget=50, time_limit_s=0.5, jobs=1)
    lost, other = (next(run for run in result.runs if run.algorithm == name) for name in (algorithm, "random"))
    assert lost.state == "failed"
    assert lost.reason.startswith(("it hung", "its process died"))
    assert lost.trace.costs.tolist() == [0.0]
    assert other.state == "done"


def test_a_candidate_that_takes_longer_than_the_time_limit_loses_nothing_that_was_found_before(monkeypatch):
    monkeypatch.setattr("robolaser.benchmark.compare.GRACE_S", 1.0)
    result = robolaser.compare([Stuck()], ["random"], seeds=1, budget=50, time_limit_s=0.5, jobs=1)
    (run,) = result.runs
    assert run.reason.startswith("it hung")
    assert len(run.trace.costs)
    assert result.to_frame()["best"].tolist() == [run.trace.final]


def test_a_run_of_several_objectives_that_is_killed_keeps_its_front(monkeypatch):
    monkeypatch.setattr("robolaser.benchmark.compare.GRACE_S", 1.0)
    result = robolaser.compare([Stuck(2)], ["random"], seeds=1, budget=50, time_limit_s=0.5, jobs=1)
    assert result.made[0].trace.costs.shape[1] == 2


def test_what_is_half_written_is_left_out(tmp_path):
    (tmp_path / "spill").write_text("[1, 0.1, 3.0]\n[2, 0.2, 1.0]\n[3, 0.3, [0.")
    run = Task("p", "a", 1, RunLimits(10, 1.0), b"", b"", "", spill=str(tmp_path / "spill")).lost("it hung")
    assert (run.evaluations, run.trace.costs.tolist()) == (2, [3.0, 1.0])


def test_a_noisy_problem_keeps_no_luckiest_sample_of_a_run_that_is_killed(monkeypatch):
    monkeypatch.setattr("robolaser.benchmark.compare.GRACE_S", 1.0)
    result = robolaser.compare(["mine:Noisy"], ["mine:hanging"], seeds=1, budget=50, time_limit_s=0.5, jobs=1)
    assert result.problems[0].noisy
    assert not len(result.runs[0].trace.costs)


def test_the_exit_status_says_when_nothing_ran(tmp_path, capsys):
    assert main(["compare", "mine:Whole", "--algorithms", "de", "--output", str(tmp_path / "a")]) == 1
    said = capsys.readouterr()
    assert "No algorithm could be run" in said.err
    assert "No algorithm could be run" in said.out
    typed = ["compare", "mine:Sphere", "--algorithms", "mine:raising", "--seeds", "1", "--output", str(tmp_path / "b")]
    assert main(typed) == 1
    assert "Every run failed" in capsys.readouterr().err
