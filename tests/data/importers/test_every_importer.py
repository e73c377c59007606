"""The contract of all importers: what they read can be loaded, nothing is lost, and nothing is written on an error."""

import json
import shutil
from dataclasses import dataclass
from pathlib import Path

import pytest

from examples import EXAMPLES
from robolaser import import_files, load
from robolaser.cli import main
from robolaser.data.dataset import Dataset
from robolaser.data.importers import importer_for, importers
from robolaser.diagnosis import preparation
from robolaser.errors import UsageError


@dataclass
class Case:
    kind: str
    sources: list[Path]
    options: list[str]
    output: Path

    def run(self, *more: str) -> int:
        sources = [str(path) for path in self.sources]
        named = ["--kind", self.kind]
        return main(["import", *sources, *named, "--output", str(self.output), *self.options, *more])

    @property
    def files(self) -> list[Path]:
        """All that is read: of a folder every file."""
        inside = [file for path in self.sources if path.is_dir() for file in path.rglob("*") if file.is_file()]
        return inside + [path for path in self.sources if path.is_file()]


def contents(folder: Path) -> dict[str, bytes]:
    return {str(path.relative_to(folder)): path.read_bytes() for path in folder.rglob("*") if path.is_file()}


@pytest.fixture(params=[kind for kind, importer in importers().items() if importer.__module__.startswith("robolaser.")])
def case(request: pytest.FixtureRequest, tmp_path: Path) -> Case:
    folder = tmp_path / "raw"
    folder.mkdir()
    return Case(request.param, *EXAMPLES[request.param](folder), tmp_path / "cell")


SOUGHT: dict[str, tuple[str, ...]] = {}


@pytest.fixture(autouse=True)
def mistakes_are_sought_once(case: Case, monkeypatch: pytest.MonkeyPatch) -> None:
    """In the data of an example they are the same each time, and take longer than all else."""
    seek = preparation.gross_mistakes

    def remembered(dataset: Dataset) -> tuple[str, ...]:
        if case.kind not in SOUGHT:
            SOUGHT[case.kind] = seek(dataset)
        return SOUGHT[case.kind]

    monkeypatch.setattr(preparation, "gross_mistakes", remembered)


def test_without_a_file_there_is_nothing_to_import(case):
    with pytest.raises(UsageError, match="Name a file or folder"):
        import_files(kind=case.kind)


def test_it_recognises_its_files_and_nothing_that_is_not_there(case, tmp_path):
    assert importer_for(case.sources).name == case.kind
    importer = importers()[case.kind]()
    assert not importer.recognises(tmp_path / "nothing.xyz")
    assert not importer.recognises(tmp_path)


def test_it_says_what_it_is_in_one_line(case):
    title = importers()[case.kind].title
    assert title
    assert "\n" not in title
    assert not title.endswith(".")


def test_what_it_reads_can_be_loaded_and_the_files_stay_as_they_were(case):
    before = contents(case.output.parent / "raw")
    assert case.run() == 0
    dataset = load(case.output)
    assert len(dataset.poses) > 0
    assert dataset.name == "cell"
    assert all((case.output / image).is_file() for image in dataset.poses.image or ())
    assert contents(case.output.parent / "raw") == before


def test_it_reads_the_same_each_time(case):
    assert case.run() == 0
    first = contents(case.output)
    shutil.rmtree(case.output)
    assert case.run() == 0
    assert contents(case.output) == first


def test_every_column_is_shown_with_its_source_before_anything_is_written(case, capsys):
    assert case.run("--dry-run") == 0
    shown = capsys.readouterr().out
    assert not case.output.exists()
    assert case.run("--json") == 0
    said = json.loads(capsys.readouterr().out)
    for table in ("poses.csv", "points.csv"):
        if (case.output / table).exists():
            written = (case.output / table).read_text(encoding="utf-8").splitlines()[0].split(",")
            assert sorted(written) == sorted(said["columns"][table])
            assert all(one["read_from"] and len(one["first"]) == 3 for one in said["columns"][table].values())
            assert all(f"  {column} " in shown for column in written)


def test_a_damaged_file_ends_with_its_name_and_nothing_is_written(case, capsys):
    for source in case.files:
        whole = source.read_bytes()
        for damaged in (b"", b"\x00\xff\xfe" * 50):
            source.write_bytes(damaged)
            assert case.run() == 1
            said = capsys.readouterr()
            assert said.out == ""
            assert said.err.startswith("robolaser: ")
            assert said.err.count("\n") == 1
            assert source.name in said.err
            assert not case.output.exists()
        source.write_bytes(whole)


def test_a_file_that_is_not_there_ends_with_a_sentence(case, capsys):
    for source in case.sources:
        shutil.rmtree(source) if source.is_dir() else source.unlink()
    assert case.run() in (1, 2)
    assert case.sources[0].name in capsys.readouterr().err
    assert not case.output.exists()


def test_a_data_set_is_overwritten_only_by_force(case, capsys):
    assert case.run() == 0
    (case.output / "poses.csv").write_text("mine", encoding="utf-8")
    before = contents(case.output)
    assert case.run() == 1
    assert "--force" in capsys.readouterr().err
    assert contents(case.output) == before
    assert case.run("--force") == 0
    load(case.output)


@pytest.mark.parametrize("file", ["poses.csv", "points.csv", "robot.urdf"])
def test_a_file_that_is_of_no_data_set_is_never_overwritten(case, file):
    case.output.mkdir()
    (case.output / file).write_text("mine", encoding="utf-8")
    assert case.run("--force") == 1
    assert contents(case.output) == {file: b"mine"}


def test_nothing_is_written_into_the_folder_that_is_read(case):
    raw = case.output.parent / "raw"
    before = contents(raw)
    folders = [source for source in case.sources if source.is_dir()]
    for output in [*case.sources, *(folder / "cell" for folder in folders)]:
        case.output = output
        assert case.run() == 1
        assert case.run("--force") == 1
        assert contents(raw) == before
