"""What is exported reads back, with the field's own tool, as what was run."""

import json
from dataclasses import replace

import numpy as np
import pytest
from made_up import made_up_comparison, made_up_run

from robolaser.benchmark.result_files import exported
from robolaser.data.result_folder import write_results

iohinspector = pytest.importorskip("iohinspector")


def export(result, folder):
    write_results(folder, exported(result, iohprofiler=True))


@pytest.fixture
def comparison():
    return made_up_comparison({"de": 1.0, "rcga:b=2": 2.0, "my.own:Search": 0.5}, seeds=3)


@pytest.fixture
def read(comparison, tmp_path):
    export(comparison, tmp_path)
    manager = iohinspector.DataManager()
    manager.add_folder(str(tmp_path))
    return manager


def test_every_run_is_there_with_its_best_cost(comparison, read):
    rows = read.overview.select("algorithm_name", "function_name", "instance", "evals", "best_y").rows()
    assert sorted(rows) == sorted(
        (run.algorithm, run.problem, run.seed, run.evaluations, run.trace.final) for run in comparison.runs
    )


def test_every_course_is_there_improvement_by_improvement(comparison, read):
    loaded = read.load(monotonic=True, include_meta_data=True)
    for run in comparison.runs:
        rows = loaded.filter(
            (loaded["algorithm_name"] == run.algorithm)
            & (loaded["function_name"] == run.problem)
            & (loaded["instance"] == run.seed)
        )
        found = np.array([row for row in rows.select("evaluations", "raw_y").rows() if np.isfinite(row[1])])
        np.testing.assert_array_equal(found[:, 0], run.trace.evaluations)
        np.testing.assert_allclose(found[:, 1], run.trace.costs, rtol=1e-12)


def test_a_run_that_found_nothing_is_left_out(comparison, tmp_path):
    empty = made_up_run("de", 9)
    empty = replace(empty, trace=type(empty.trace)(np.array([], int), np.array([]), np.array([])))
    export(replace(comparison, runs=(empty,)), tmp_path / "none")
    assert not list(tmp_path.glob("none/**/*.json"))


def test_what_is_written_is_plain_json(comparison, tmp_path):
    export(comparison, tmp_path)
    for path in tmp_path.glob("**/*.json"):
        json.loads(path.read_text(), parse_constant=pytest.fail)
