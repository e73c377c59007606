"""Runs are on disk as soon as they are done, and come back as they were."""

import json
from dataclasses import replace

import numpy as np
import pytest
from made_up import made_up_run

from robolaser.benchmark.plan import RunPlan, key
from robolaser.benchmark.problem_specs import specs_of
from robolaser.benchmark.record import RunRecord
from robolaser.benchmark.solvers import find
from robolaser.errors import BenchmarkError, OutputError


def plan(*problems: str, **changed) -> RunPlan:
    asked = {"seeds": (1, 2), "budget": 1000, "time_limit_s": 10.0, "memory_limit_b": 10**9}
    return RunPlan(specs_of(problems or ("pymoo:sphere",)), (find("random"),), **(asked | changed))


@pytest.fixture
def path(tmp_path):
    return tmp_path / "runs.jsonl"


@pytest.fixture
def record(path):
    record = RunRecord(path)
    record.begin(plan(), engine="this machine", workers=2)
    record.add(made_up_run("random", 1), after_s=1.0)
    record.add(made_up_run("random", 2), after_s=2.5)
    return record


def same(one, other) -> bool:
    plain = [{name: value for name, value in vars(run).items() if name != "trace"} for run in (one, other)]
    return (
        plain[0] == plain[1]
        and np.array_equal(one.trace.evaluations, other.trace.evaluations)
        and np.array_equal(one.trace.costs, other.trace.costs)
        and np.allclose(one.trace.seconds, other.trace.seconds, rtol=0.0, atol=1e-6)
    )


def test_runs_read_back_to_the_last_bit_and_their_seconds_to_the_microsecond(record, path):
    for one, other in zip(record.runs, RunRecord(path).runs, strict=True):
        assert same(one, other)


def test_a_line_that_was_cut_off_costs_only_its_run(record, path):
    whole = path.read_bytes()
    path.write_bytes(whole[:-20])
    cut = RunRecord(path)
    assert [key(run) for run in cut.runs] == [("paper", "random", 1)]
    cut.begin(plan(), engine="this machine", workers=2)
    cut.add(made_up_run("random", 3), after_s=0.1)
    assert [run.seed for run in RunRecord(path).runs] == [1, 3]


def test_a_file_that_is_no_record_is_refused_with_its_line(record, path):
    path.write_text(path.read_text() + "what\n" + json.dumps({"run": {}}) + "\n")
    with pytest.raises(BenchmarkError, match="line 5"):
        RunRecord(path)


@pytest.mark.parametrize(
    "text", ["my notes\n", "my notes", '{"run": {}}\n', '{"session": {"engine": "", "workers": 1}}\n', "\x00\r\n"]
)
def test_somebody_elses_file_is_refused_and_left_alone(text, path):
    path.write_bytes(text.encode())
    with pytest.raises(BenchmarkError):
        RunRecord(path)
    assert path.read_bytes() == text.encode()


def test_runs_by_another_version_do_not_compare(record, path, monkeypatch):
    monkeypatch.setattr("robolaser.benchmark.record.version", lambda package: "99")
    with pytest.raises(BenchmarkError, match="robolaser is"):
        RunRecord(path).begin(plan(), engine="this machine", workers=2)


def test_a_later_format_is_refused(record, path):
    path.write_text(path.read_text().replace("robolaser-runs/1", "robolaser-runs/9"))
    with pytest.raises(BenchmarkError, match="robolaser-runs/9"):
        RunRecord(path)


@pytest.mark.parametrize(
    ("other", "what"),
    [({"budget": 999}, "budget is 1000 there, here it is 999"), ({"time_limit_s": 9.0}, "time_limit_s is 10.0")],
)
def test_runs_under_other_conditions_do_not_compare(record, path, other, what):
    with pytest.raises(BenchmarkError, match=what):
        RunRecord(path).begin(plan(**other), engine="this machine", workers=2)


def test_a_problem_that_changed_under_its_name_is_noticed(record, path):
    changed = plan()
    name = changed.specs[0].name
    changed.fingerprints[name] += "0"
    with pytest.raises(BenchmarkError, match=f"the problem {name}"):
        RunRecord(path).begin(changed, engine="this machine", workers=2)


def test_more_seeds_problems_and_solvers_may_come_to_a_record(record, path):
    more = plan("pymoo:sphere", "pymoo:ackley", seeds=(1, 2, 3))
    RunRecord(path).begin(more, engine="this machine", workers=2)
    assert len(RunRecord(path).runs) == 2


def test_runs_that_failed_are_to_be_made_again(record, path):
    record.add(made_up_run("random", 3, reason="its process died"), after_s=3.0)
    assert [run.seed for run in record.made] == [1, 2]
    record.add(made_up_run("random", 3), after_s=4.0)
    assert [run.seed for run in RunRecord(path).made] == [1, 2, 3]


def test_effort_adds_up_over_sessions(record, path):
    again = RunRecord(path)
    again.begin(plan(), engine="tcp://there:8786", workers=10)
    again.add(made_up_run("random", 3), after_s=4.0)
    effort = RunRecord(path).effort
    assert (effort.engine, effort.workers, effort.seconds) == ("tcp://there:8786", 10, 6.5)
    assert effort.capacity_s == 2.5 * 2 + 4.0 * 10
    assert effort.busy_s == pytest.approx(3 * made_up_run("random", 1).seconds)


def test_a_run_that_found_nothing_is_kept_too(record, path):
    nothing = replace(made_up_run("random", 5), trace=type(record.runs[0].trace)(*(np.array([]),) * 3))
    record.add(nothing, after_s=5.0)
    assert np.isinf(RunRecord(path).runs[-1].trace.final)


def test_a_record_that_cannot_be_written_says_so(tmp_path):
    with pytest.raises(OutputError):
        RunRecord(tmp_path / "nowhere" / "runs.jsonl").begin(plan(), engine="", workers=1)
