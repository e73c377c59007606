"""Files that belong together are each whole, and old and new ones never mixed, whatever happens meanwhile."""

import errno
from contextlib import suppress

import pytest
from failing_disk import contents, failing, restore, watched

from robolaser.data.result_folder import STAGED, write_together
from robolaser.errors import OutputError

OLD = {"a": b"old", "b": b"old", "deep/c": b"old", "gone": b"old"}
NEW = {"a": b"new", "b": b"new", "deep/c": b"new"}


def visible(folder):
    return visible_of(contents(folder))


def visible_of(moment):
    return {name: data for name, data in moment.items() if not name.rpartition("/")[2].startswith(".")}


def replace_all(folder):
    write_together(folder, NEW, list(OLD))


@pytest.fixture
def folder(tmp_path):
    folder = tmp_path / "folder"
    folder.mkdir()
    restore(folder, OLD)
    return folder


def moments_of(folder, write=replace_all):
    moments = []
    with watched(folder, lambda _: moments.append(contents(folder))):
        write(folder)
    return moments


def test_killed_at_any_moment_there_are_files_of_one_result_only(folder):
    for moment in moments_of(folder):
        restore(folder, moment)
        assert visible(folder).items() <= OLD.items() or visible(folder).items() <= NEW.items()


def test_killed_at_any_moment_what_is_not_to_be_deleted_is_whole_and_there(folder):
    for moment in moments_of(folder, lambda folder: write_together(folder, NEW)):
        restore(folder, moment)
        seen = visible(folder)
        assert set(seen) == set(OLD)
        assert all(data in (OLD[name], NEW.get(name)) for name, data in seen.items())


def test_files_take_their_names_in_their_order(folder):
    replaced = [
        sum(visible_at[name] == b"new" for name in ("a", "b", "deep/c"))
        for visible_at in moments_of(folder, lambda folder: write_together(folder, NEW))
    ]
    assert replaced == sorted(replaced)
    assert contents(folder)["deep/c"] == b"new"


@pytest.mark.parametrize("kind", [errno.ENOSPC, errno.EROFS])
def test_a_full_disk_leaves_what_was_there_and_nothing_half_done(folder, kind):
    growing = [number for number, moment in enumerate(moments_of(folder)) if visible_of(moment) == OLD]
    for number in growing[:-1]:
        restore(folder, OLD)
        with watched(folder, failing(number, kind)), suppress(OutputError):
            replace_all(folder)
        assert visible(folder) in (OLD, NEW)


def test_a_staged_file_is_called_in_messages_what_it_is_to_be_called(tmp_path):
    with pytest.raises(OutputError, match=r"nowhere/cloud\.ply"):
        write_together(tmp_path / "nowhere", {f"{STAGED}cloud.ply": b""})
