"""Tables and files: what is read is what was written, and what was there is never damaged."""

import errno
import os
from contextlib import suppress
from pathlib import Path

import numpy as np
import pytest

from robolaser.errors import FileUnwritable, RobolaserError
from robolaser.tables import read_table, write_table, write_text


def test_what_is_written_is_read(tmp_path: Path) -> None:
    names = ["plain", 'with "quotes"', "with, comma", "ünïcode"]
    write_table(tmp_path / "t.csv", ["name", "x"], [(name, 0.1 * i) for i, name in enumerate(names)])
    table = read_table(tmp_path / "t.csv")
    assert list(table.texts("name")) == names
    np.testing.assert_allclose(table.numbers(["x"])[:, 0], 0.1 * np.arange(4), rtol=1e-11)


def test_lines_are_counted_as_an_editor_counts_them(tmp_path: Path) -> None:
    (tmp_path / "t.csv").write_text('a,b\n\n1,"two\nlines"\n3,x\n')
    assert read_table(tmp_path / "t.csv").lines == (3, 5)


@pytest.mark.parametrize("step", ["fsync", "replace"])
def test_a_full_disk_leaves_what_was_there(tmp_path: Path, monkeypatch: pytest.MonkeyPatch, step: str) -> None:
    path = tmp_path / "result.json"
    write_text(path, "before")

    def full(*_: object) -> None:
        raise OSError(errno.ENOSPC, "No space left on device")

    monkeypatch.setattr(os, step, full)
    with pytest.raises(FileUnwritable, match=r"No space left.*unchanged"):
        write_text(path, "after")
    assert path.read_text() == "before"
    assert [p.name for p in tmp_path.iterdir()] == ["result.json"]


def test_truncated_and_damaged_tables_only_ever_raise_our_errors(tmp_path: Path) -> None:
    rng = np.random.default_rng(2)
    good = b"pose,x,y\n" + b"".join(b'"p%d",%d.5,-1e-3\n' % (i, i) for i in range(20))
    path = tmp_path / "t.csv"
    for _ in range(300):
        data = bytearray(good[: rng.integers(0, len(good) + 1)])
        for at in rng.integers(0, max(1, len(data)), rng.integers(0, 4)):
            if data:
                data[at] = rng.integers(0, 256)
        path.write_bytes(bytes(data))
        with suppress(RobolaserError):
            table = read_table(path)
            table.texts("pose")
            assert np.isfinite(table.numbers(["x", "y"])).all()
