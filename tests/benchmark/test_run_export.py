"""A run that found nothing is in every export."""

import csv
import io
import json

import pytest

import robolaser
from robolaser.benchmark.export import iohprofiler_files, runs_csv


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
