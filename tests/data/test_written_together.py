"""Files that belong together are all old or all new, whatever happens while they are written."""

import errno
import json
from contextlib import suppress

import pytest
from failing_disk import contents, failing, restore, watched

from robolaser.data.atomic_write import JOURNAL, finish_for_the_dead, finish_writing, locked, write_together
from robolaser.errors import OutputError

OLD = {"a": b"old", "b": b"old", "deep/c": b"old", "gone": b"old"}
NEW = {"a": b"new", "b": b"new", "deep/c": b"new"}


def visible(folder):
    finish_writing(folder)
    return {name: data for name, data in contents(folder).items() if not name.rpartition("/")[2].startswith(".")}


def replace_all(folder):
    write_together(folder, NEW, ["gone", "a"])


@pytest.fixture
def folder(tmp_path):
    folder = tmp_path / "folder"
    folder.mkdir()
    restore(folder, OLD)
    return folder


def moments_of(folder):
    moments = []
    with watched(folder, lambda _: moments.append(contents(folder))):
        replace_all(folder)
    return moments


def test_killed_at_any_moment_all_are_old_or_all_are_new(folder):
    seen = []
    for moment in moments_of(folder):
        restore(folder, moment)
        seen.append(visible(folder))
    assert [seen.count(OLD), seen.count(NEW)] == [seen.index(NEW), len(seen) - seen.index(NEW)]


@pytest.mark.parametrize("kind", [errno.ENOSPC, errno.EROFS])
def test_refused_at_any_moment_all_are_old_or_all_are_new(folder, kind):
    for number in range(len(moments_of(folder))):
        restore(folder, OLD)
        with watched(folder, failing(number, kind)), suppress(OutputError):
            replace_all(folder)
        assert visible(folder) in (OLD, NEW)
    assert not [name for name in contents(folder) if "robolaser" in name]


@pytest.mark.parametrize(
    "journal",
    [
        "{",
        "[" * 100_000,
        '{"rename": 3}',
        '{"rename": {".x": "../out"}, "delete": []}',
        '{"rename": {"../secret": "mine"}, "delete": []}',
        '{"rename": {}, "delete": ["/etc/hostname", "../secret"]}',
        '{"rename": {".x": "link/secret"}, "delete": []}',
    ],
)
def test_a_journal_that_is_not_ours_moves_nothing(tmp_path, folder, journal):
    (tmp_path / "secret").write_text("mine")
    (folder / ".x").write_text("theirs")
    (folder / "link").symlink_to(tmp_path)
    (folder / JOURNAL).write_text(journal)
    finish_writing(folder)
    assert (tmp_path / "secret").read_text() == "mine"
    assert not (tmp_path / "out").exists()
    assert (folder / ".x").exists()


def test_what_was_renamed_before_the_kill_is_not_missed(folder):
    (folder / ".b").write_bytes(b"new")
    (folder / JOURNAL).write_text(json.dumps({"rename": {".a": "a", ".b": "b"}, "delete": ["gone"]}))
    assert visible(folder) == {"a": b"old", "b": b"new", "deep/c": b"old"}


def test_a_reader_leaves_the_journal_of_a_living_writer_alone(folder):
    (folder / ".a").write_bytes(b"new")
    (folder / JOURNAL).write_text(json.dumps({"rename": {".a": "a"}, "delete": []}))
    with locked(folder) as free:
        assert free
        finish_for_the_dead(folder)
        assert (folder / "a").read_bytes() == b"old"
    finish_for_the_dead(folder)
    assert (folder / "a").read_bytes() == b"new"
