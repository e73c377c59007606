"""Tables and files: what is read is what was written, and what was there is never damaged."""

import errno
import os

import numpy as np
import pytest

from robolaser.data.csv_tables import read_table
from robolaser.data.result_folder import write_text
from robolaser.errors import DataError, OutputError


def test_lines_are_counted_as_an_editor_counts_them(tmp_path):
    (tmp_path / "t.csv").write_text('a,b\n\n1,"two\nlines"\n3,x\n')
    assert read_table(tmp_path / "t.csv").lines == (3, 5)


@pytest.mark.parametrize("step", ["fsync", "replace"])
def test_a_full_disk_leaves_what_was_there(tmp_path, monkeypatch, step):
    path = tmp_path / "result.json"
    write_text(path, "before")

    def full(*_: object) -> None:
        raise OSError(errno.ENOSPC, "No space left on device")

    monkeypatch.setattr(os, step, full)
    with pytest.raises(OutputError, match=r"No space left.*unchanged"):
        write_text(path, "after")
    assert path.read_text() == "before"
    assert [p.name for p in tmp_path.iterdir()] == ["result.json"]


def tables_of(text: str) -> list[str]:
    """The same table as plainly written, with all or later cells in quotes, with blank lines, a BOM and CRLF."""
    rows = [line.split(",") for line in text.splitlines()]
    quoted = "\n".join(",".join(f'"{cell}"' for cell in row) for row in rows)
    later = "\n".join(text.splitlines()[:9] + quoted.splitlines()[9:])
    return [text, text.rstrip("\n"), quoted, later, text + "\n\n", "\ufeff" + text.replace("\n", "\r\n"), "\n" + text]


@pytest.mark.parametrize("chunk", [7, 1 << 17])
def test_numbers_are_the_same_however_a_table_is_written(tmp_path, monkeypatch, chunk):
    monkeypatch.setattr("robolaser.data.csv_tables.BLOCK_ROWS", chunk)
    values = np.random.default_rng(3).normal(size=(30, 2)) * 10.0 ** np.arange(-15, 15)[:, None]
    text = "name,x, y \n" + "".join(f"p_{i % 4}, {x!r} ,{y:.7g}\n" for i, (x, y) in enumerate(values.tolist()))
    for i, written in enumerate(tables_of(text)):
        path = tmp_path / f"{i}.csv"
        path.write_bytes(written.encode())
        table, slow = read_table(path, ["x", "y"]), read_table(path)
        assert np.array_equal(table.numbers(["x", "y"]), slow.numbers(["x", "y"]))
        assert table.texts("name") == slow.texts("name")
        assert tuple(table.lines) == tuple(slow.lines)
        assert np.array_equal(table.numbers(["x"])[:, 0], values[:, 0])


@pytest.mark.parametrize("text", ["pose;q_1\n0;0,5\n", "pose\tq_1\n0\t0.5\n"])
def test_a_table_with_other_separators_is_named_as_that(tmp_path, text):
    (tmp_path / "poses.csv").write_text(text)
    with pytest.raises(DataError, match=r"poses\.csv, row 1: the columns are separated by .*expected commas.*import"):
        read_table(tmp_path / "poses.csv")


def test_equal_texts_are_kept_once(tmp_path):
    (tmp_path / "t.csv").write_text("pose,x\n" + "a long name,1\n" * 9)
    assert len({id(cell) for cell in read_table(tmp_path / "t.csv", ["x"]).texts("pose")}) == 1
