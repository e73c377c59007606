"""An importer that an installed package announces takes part like ours."""

import json
import sys
from collections.abc import Callable, Iterator
from pathlib import Path

import pytest
from installed import installed

from robolaser import load
from robolaser.cli import main
from robolaser.data.importers import importers
from robolaser.errors import PluginError

WORKING = """
import json

import numpy as np

from robolaser.data.dataset import Dataset, Points, Poses
from robolaser.data.importers import Imported, Importer
from robolaser.errors import DataError

class Records(Importer):
    name = "records"
    title = "tracked points in one JSON file"
    further = ("key",)

    def recognises(self, path):
        return path.suffix == ".json"

    def read(self, paths, options):
        records = json.loads(paths[0].read_text())[options.further.get("key", "records")]
        T = np.eye(4)[None].repeat(len(records), 0)
        xyz = np.array([record["xyz"] for record in records], dtype=float)
        poses = Poses(tuple(str(i) for i in range(len(records))), T_base_flange=T)
        points = Points(np.arange(len(records)), ("ball",) * len(records), xyz=xyz)
        return Imported(Dataset(options.name, poses, points, kind="point"))
"""


@pytest.fixture
def install(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Iterator[Callable[[str], None]]:
    """Put a package that announces an importer where Python finds it."""

    def put(code: str) -> None:
        installed(tmp_path, "recorded", code, "[robolaser.importers]\nany = recorded:Records\n")
        monkeypatch.syspath_prepend(tmp_path)
        monkeypatch.delitem(sys.modules, "recorded", raising=False)

    importers.cache_clear()
    yield put
    importers.cache_clear()


@pytest.fixture
def file(tmp_path: Path) -> Path:
    path = tmp_path / "seen.json"
    path.write_text(json.dumps({"shots": [{"xyz": [i, 0.5, 1.0]} for i in range(4)]}), "utf-8")
    return path


def test_its_files_become_a_data_set(install, file, tmp_path):
    install(WORKING)
    assert main(["import", str(file), "--set", "key=shots", "--output", str(tmp_path / "cell")]) == 0
    assert load(tmp_path / "cell").points.xyz[:, 0].tolist() == [0, 1, 2, 3]


def test_what_it_reads_is_checked_before_it_is_written(install, file, tmp_path, capsys):
    install(WORKING.replace("dtype=float)", "dtype=float) * 1e3"))
    assert main(["import", str(file), "--set", "key=shots", "--output", str(tmp_path / "cell")]) == 1
    assert "points.csv, row 2, column y_m: 500 m is farther" in capsys.readouterr().err
    assert not (tmp_path / "cell").exists()


def test_an_option_that_it_does_not_have_is_wrong_usage(install, file, tmp_path, capsys):
    install(WORKING)
    assert main(["import", str(file), "--set", "keys=shots", "--output", str(tmp_path / "cell")]) == 2
    assert "Did you mean 'key'?" in capsys.readouterr().err


def test_it_is_listed_beside_ours(install, capsys):
    install(WORKING)
    assert main(["list", "importers", "--json"]) == 0
    listed = [entry["importer"] for entry in json.loads(capsys.readouterr().out)["importers"]]
    assert "csv" in listed
    assert listed[-1] == "records"


def test_where_several_recognise_a_file_one_has_to_be_named(install, file, tmp_path, capsys):
    install(WORKING.replace('".json"', '".csv"'))
    renamed = str(file.rename(tmp_path / "seen.csv"))
    assert main(["import", renamed, "--output", str(tmp_path / "cell")]) == 2
    assert "Several importers recognise" in capsys.readouterr().err
    words = ["import", renamed, "--kind", "records", "--set", "key=shots", "--output", str(tmp_path / "cell")]
    assert main(words) == 0


def test_a_file_that_nobody_recognises_is_wrong_usage(install, file, tmp_path, capsys):
    assert main(["import", str(file), "--output", str(tmp_path / "cell")]) == 2
    assert f"No importer recognises '{file}'. Name one with --kind" in capsys.readouterr().err
    assert main(["import", str(tmp_path), "--output", str(tmp_path / "cell")]) == 2
    assert "Name the files in the folder, or one with --kind" in capsys.readouterr().err


def test_an_incomplete_importer_is_named_with_its_package(install):
    install(WORKING.replace("def recognises", "def recognizes"))
    with pytest.raises(PluginError, match=r"recorded announces recorded:Records .* does not define recognises"):
        importers()
