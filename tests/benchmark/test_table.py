"""Runs are on disk as soon as they are done, whoever writes them, and come back as they were."""

import multiprocessing
import sqlite3
from dataclasses import replace
from pathlib import Path

import numpy as np
import pandas as pd
import pytest
from made_up import made_up_comparison, made_up_run

from robolaser.benchmark import load
from robolaser.benchmark.plan import RunPlan
from robolaser.benchmark.problem_specs import specs_of
from robolaser.benchmark.result_arrays import TOLERANCES
from robolaser.benchmark.solvers import find
from robolaser.benchmark.table import NAME, RunTable
from robolaser.errors import BenchmarkError, OutputError

SPHERE = "pymoo:sphere-10"


def plan(*problems: str, **changed) -> RunPlan:
    asked = {"seeds": (1, 2), "budget": 1000, "time_limit_s": 10.0, "memory_limit_b": 10**9}
    return RunPlan(specs_of(problems or (SPHERE,)), (find("random"),), **(asked | changed))


def made(seed: int, **more):
    return made_up_run("random", seed, problem=SPHERE, **more)


@pytest.fixture
def path(tmp_path):
    return tmp_path / NAME


@pytest.fixture
def table(path):
    with RunTable(path) as table:
        table.begin(plan(), engine="this machine", workers=2)
        table.add(made(1), after_s=1.0)
        table.add(made(2), after_s=2.5)
        yield table


def read(path: Path):
    return load(path).runs


def same(one, other) -> bool:
    plain = [{name: value for name, value in vars(run).items() if name != "trace"} for run in (one, other)]
    traces = zip(vars(one.trace).values(), vars(other.trace).values(), strict=True)
    return plain[0] == plain[1] and all(np.array_equal(mine, theirs) for mine, theirs in traces)


def test_runs_read_back_to_the_last_bit_while_they_are_written_and_after(table, path):
    for _ in range(2):
        assert all(same(one, made(one.seed)) for one in read(path))
        assert [run.seed for run in read(path)] == [1, 2]
        table.close()
    assert [file.name for file in path.parent.iterdir()] == [NAME]


def writes(path: Path, first: int, last: int, told=lambda seed: None) -> None:
    with RunTable(path) as table:
        table.begin(plan(), engine="this machine", workers=1)
        for seed in range(first, last):
            table.add(made(seed), after_s=1.0)
            told(seed)


def started(*arguments) -> multiprocessing.Process:
    process = multiprocessing.get_context("fork").Process(target=writes, args=arguments)
    process.start()
    return process


def all_there(path: Path) -> list:
    everything = plan(seeds=tuple(range(1, 100_000)))
    with RunTable(path) as table:
        return sorted(table.result(everything).runs, key=lambda run: run.seed)


def test_several_programs_write_at_the_same_time_and_no_run_is_lost(path):
    writers = [started(path, first, first + 40) for first in (1, 41, 81)]
    for writer in writers:
        writer.join(60)
        assert writer.exitcode == 0
    assert [run.seed for run in all_there(path)] == list(range(1, 121))
    assert all(same(run, made(run.seed)) for run in all_there(path))


def test_whoever_is_killed_loses_no_run_that_was_added(path):
    ours, theirs = multiprocessing.Pipe(duplex=False)
    writer = started(path, 1, 99_999, theirs.send)
    told = [ours.recv() for _ in range(30)]
    writer.kill()
    writer.join()
    while ours.poll():
        told.append(ours.recv())
    found = all_there(path)
    assert [run.seed for run in found][: len(told)] == told
    assert all(same(run, made(run.seed)) for run in found)
    assert len(found) - len(told) <= 1
    writes(path, len(found) + 1, len(found) + 3)
    assert len(all_there(path)) == len(found) + 2


def test_runs_that_failed_are_to_be_made_again_and_are_replaced(table, path):
    table.add(made(3, reason="its process died"), after_s=3.0)
    assert {seed for _, _, seed in table.made()} == {1, 2}
    table.add(made(3), after_s=4.0)
    assert {seed for _, _, seed in table.made()} == {1, 2, 3}
    assert len(table) == 3
    assert sqlite3.connect(path).execute("select count(distinct run) from trajectory").fetchone() == (3,)


def test_effort_adds_up_over_sessions(table, path):
    with RunTable(path) as again:
        again.begin(plan(), engine="tcp://there:8786", workers=10)
        again.add(made(3), after_s=4.0)
    effort = load(path).effort
    assert (effort.engine, effort.workers, effort.seconds) == ("tcp://there:8786", 10, 6.5)
    assert effort.capacity_s == 2.5 * 2 + 4.0 * 10
    assert effort.busy_s == pytest.approx(3 * made(1).seconds)


def test_a_run_that_found_nothing_is_kept_too(table, path):
    nothing = replace(made(5), trace=type(made(5).trace)(np.array([], int), *(np.array([]),) * 2))
    table.add(nothing, after_s=5.0)
    assert np.isinf(table.result(plan(seeds=(5,))).runs[0].trace.final)


@pytest.mark.parametrize(
    ("other", "what"),
    [({"budget": 999}, "budget is 1000 there, here it is 999"), ({"time_limit_s": 9.0}, "time_limit_s is 10.0")],
)
def test_runs_under_other_conditions_do_not_compare(table, path, other, what):
    with RunTable(path) as again, pytest.raises(BenchmarkError, match=what):
        again.begin(plan(**other), engine="this machine", workers=2)
    assert len(read(path)) == 2


def test_a_problem_that_changed_under_its_name_is_noticed(table, path, monkeypatch):
    monkeypatch.setattr("robolaser.benchmark.table.fingerprint", lambda problem: "another")
    with RunTable(path) as again, pytest.raises(BenchmarkError, match=f"the problem {SPHERE}"):
        again.begin(plan(), engine="this machine", workers=2)


@pytest.mark.parametrize(("problem", "asked"), [("paper", True), (SPHERE, False)])
def test_the_version_of_numba_counts_only_where_its_loops_are_run(problem, asked):
    assert ("numba" in plan(problem).packages) == asked


def test_more_seeds_problems_and_solvers_may_come_to_a_table(table, path):
    more = plan("pymoo:sphere", "pymoo:ackley", seeds=(1, 2, 3))
    table.begin(more, engine="this machine", workers=2)
    result = table.result()
    assert [problem.name for problem in result.problems] == [SPHERE, "pymoo:ackley-10"]
    assert (result.seeds, len(result.runs), result.wanted) == ((1, 2, 3), 2, 6)


@pytest.mark.parametrize(
    ("text", "match"),
    [(b"", "another program's"), (b'{"format": "robolaser-runs/1"}\n' * 40, "not a database")],
)
def test_another_file_is_refused_in_a_sentence(path, text, match):
    path.write_bytes(text)
    with pytest.raises(BenchmarkError, match=match):
        load(path)


def test_another_programs_database_and_a_later_format_are_refused(table, path):
    table.close()
    for pragma, match in (("user_version = 9", "format 9"), ("application_id = 7", "another program's")):
        other = sqlite3.connect(path)
        other.execute(f"pragma {pragma}")
        other.close()
        with pytest.raises(BenchmarkError, match=match):
            RunTable(path)


def test_where_there_is_no_table_it_is_said_what_was_expected(tmp_path):
    with pytest.raises(BenchmarkError, match="expected the folder of a comparison"):
        load(tmp_path)


def test_a_table_that_cannot_be_written_says_so(tmp_path):
    with pytest.raises(OutputError):
        RunTable(tmp_path / "nowhere" / NAME)


def test_the_frame_has_a_row_for_each_run_improvement_or_target():
    result = made_up_comparison({"de": 1.0, "rcga": 2.0}, seeds=3)
    runs, trajectory, targets = (result.to_frame(of) for of in ("runs", "trajectory", "targets"))
    assert len(runs) == len(result.runs) == 12
    assert len(targets) == 12 * len(TOLERANCES)
    assert len(trajectory) == sum(len(run.trace.costs) for run in result.runs)
    for run in result.runs:
        named = f"problem == '{run.problem}' and algorithm == '{run.algorithm}' and seed == {run.seed}"
        (row,) = runs.query(named).itertuples()
        assert (row.best, row.excess, row.family, row.evaluations) == (
            run.trace.final,
            run.trace.final,
            "calibration",
            run.evaluations,
        )
        assert trajectory.query(named).cost.tolist() == run.trace.costs.tolist()
        assert trajectory.query(named).evaluations.tolist() == run.trace.evaluations.tolist()
        hits = targets.query(named).evaluations.astype(float).fillna(np.inf)
        assert hits.tolist() == run.trace.first_hits(TOLERANCES)[0].tolist()


@pytest.mark.parametrize("of", ["runs", "trajectory", "targets"])
def test_frames_go_to_parquet_and_back(of, tmp_path):
    pytest.importorskip("pyarrow")
    frame = made_up_comparison({"de": 1.0}, seeds=2).to_frame(of)
    frame.to_parquet(tmp_path / "table.parquet")
    pd.testing.assert_frame_equal(pd.read_parquet(tmp_path / "table.parquet"), frame)


def test_no_runs_make_an_empty_frame():
    empty = replace(made_up_comparison({"de": 1.0}), runs=())
    assert [len(empty.to_frame(of)) for of in ("runs", "trajectory", "targets")] == [0, 0, 0]
