"""Runs become arrays and files of others without a number getting lost or into the wrong place."""

import csv
import io
import json
from dataclasses import replace

import numpy as np
import pytest
from made_up import BUDGET, made_up_comparison, made_up_run

import robolaser
from robolaser.benchmark.export import iohprofiler_files, runs_csv
from robolaser.benchmark.measures import ABSOLUTE, RELATIVE, TOLERANCE, tolerances


@pytest.fixture
def comparison():
    return made_up_comparison({"de": 1.0, "rcga": 2.0}, seeds=4)


def test_each_run_is_at_its_own_place(comparison):
    arrays = comparison.arrays("calibration")
    for run in comparison.runs:
        at = arrays.problems.index(run.problem), arrays.algorithms.index(run.algorithm), arrays.seeds.index(run.seed)
        np.testing.assert_array_equal(arrays.evaluations[at], run.trace.first_hits(RELATIVE)[0])
        assert arrays.total_s[at] == run.seconds
        assert arrays.final[at] == run.trace.final


def test_what_was_not_run_is_not_a_number(comparison):
    arrays = replace(comparison, runs=comparison.runs[1:]).arrays("calibration")
    assert (~arrays.there).sum() == 1
    assert np.isnan(arrays.evaluations[~arrays.there]).all()
    assert np.isnan(arrays.final[~arrays.there]).all()


def test_a_failed_run_counts_as_if_it_had_spent_the_budget(comparison):
    failed = replace(made_up_run("de", 1, reason="gave up"), evaluations=17)
    arrays = replace(comparison, runs=(failed,)).arrays("calibration")
    assert arrays.failed.sum() == 1
    assert arrays.total_evaluations[arrays.failed] == BUDGET


def test_a_run_that_found_nothing_ends_infinitely_far_off_even_where_nobody_found_anything(comparison):
    run = made_up_run("de", 1)
    nothing = replace(run, trace=type(run.trace)(np.array([], int), np.array([]), np.array([])))
    problems = tuple(replace(problem, best=np.inf) for problem in comparison.problems)
    arrays = replace(comparison, problems=problems, runs=(nothing,)).arrays("calibration")
    assert np.isinf(arrays.final[arrays.there]).all()
    assert np.isinf(arrays.evaluations[arrays.there]).all()


def test_targets_are_measured_from_the_best_known_cost_in_units_of_it(comparison):
    problems = tuple(replace(problem, best=1e-3, floor=1e-12) for problem in comparison.problems)
    arrays = replace(comparison, problems=problems).arrays("calibration")
    at = comparison.runs[0].trace.first_hits(np.array([1e-3 * (1 + TOLERANCE)]))[0][0]
    assert arrays.evaluations[0, 0, 0, arrays.headline] == at


def test_a_target_that_is_asked_for_is_among_the_targets():
    asked = tolerances("own problem", 3e-5)
    assert len(ABSOLUTE) == 51
    assert len(asked) == 52
    assert 3e-5 in asked
    assert (np.diff(asked) < 0).all()


def test_families_are_counted_apart(comparison):
    ackley = replace(comparison.problems[0], name="pymoo:ackley-10", family="test function")
    both = replace(comparison, problems=(*comparison.problems, ackley))
    assert both.families == ("calibration", "test function")
    assert both.arrays("test function").problems == ("pymoo:ackley-10",)
    assert both.arrays("calibration").problems == ("paper", "reduced:paper")


def test_who_has_nothing_to_say_on_a_family_is_not_counted_in_it(comparison):
    asked = replace(comparison, refused={(problem.name, "de"): "no" for problem in comparison.problems})
    assert asked.arrays("calibration").algorithms == ("rcga",)
    assert asked.wanted == comparison.wanted / 2


def test_runs_that_found_nothing_are_exported():
    result = robolaser.compare(["pymoo:g5"], ["random", "rcga"], seeds=3, budget=50)
    assert all(not len(run.trace.costs) for run in result.runs)
    files = iohprofiler_files(result)
    headers = [json.loads(text, parse_constant=pytest.fail) for name, text in files.items() if name.endswith(".json")]
    assert [len(header["scenarios"][0]["runs"]) for header in headers] == [3, 3]
    table = next(text for name, text in files.items() if name.endswith(".dat"))
    assert table.splitlines()[:3] == ["evaluations raw_y seconds", "1 inf 0.0", table.splitlines()[2]]
    assert table.splitlines()[2].startswith("50 inf")
    assert {(row["algorithm"], row["seed"]) for row in csv.DictReader(io.StringIO(runs_csv(result)))} == {
        (name, str(seed)) for name in ("random", "rcga") for seed in (1, 2, 3)
    }
    assert len(result.to_frame()) == 6


def test_algorithms_with_similar_names_have_folders_of_their_own():
    result = robolaser.compare(["pymoo:sphere-2"], {"a b": "random", "a/b": "de"}, seeds=1, budget=50)
    headers = {name: text for name, text in iohprofiler_files(result).items() if name.endswith(".json")}
    assert [json.loads(text)["algorithm"]["name"] for text in headers.values()] == ["a b", "a/b"]


def test_iohinspector_reads_every_run(tmp_path):
    inspector = pytest.importorskip("iohinspector")
    result = robolaser.compare(["pymoo:sphere-2", "pymoo:g5"], ["random"], seeds=3, budget=100)
    for name, text in iohprofiler_files(result).items():
        (tmp_path / name).parent.mkdir(parents=True, exist_ok=True)
        (tmp_path / name).write_text(text)
    manager = inspector.DataManager()
    manager.add_folder(str(tmp_path / "random"))
    assert len(manager.overview) == 6
