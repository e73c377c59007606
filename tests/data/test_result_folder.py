"""A command replaces its own earlier results and nothing else, and no two commands write into one folder."""

import json
import multiprocessing
import os
import signal

import pytest

from robolaser.data.result_folder import MANIFEST, results_in
from robolaser.errors import OutputError

FILES = ("result.json", "report.html")


def write(folder, *, text="new", command="calibrate", force=False, files=FILES, **more):
    with results_in(folder, command=command, files=files, force=force, **more):
        for name in files:
            (folder / name).write_text(text)


def test_an_earlier_result_is_replaced_only_when_that_is_asked_for(tmp_path):
    write(tmp_path, text="old")
    with pytest.raises(OutputError, match="--force"):
        write(tmp_path)
    assert (tmp_path / "result.json").read_text() == "old"
    write(tmp_path, force=True)
    assert (tmp_path / "result.json").read_text() == "new"


@pytest.mark.parametrize("force", [False, True])
@pytest.mark.parametrize("name", FILES)
def test_a_file_of_the_users_is_never_replaced(tmp_path, name, force):
    (tmp_path / name).write_text("mine")
    with pytest.raises(OutputError, match=f"(?s){name}.*not its own earlier result"):
        write(tmp_path, force=force)
    assert (tmp_path / name).read_text() == "mine"
    assert sorted(file.name for file in tmp_path.iterdir()) == [name]


def test_the_result_of_another_command_stays(tmp_path):
    write(tmp_path, text="old")
    with pytest.raises(OutputError, match="a result of robolaser calibrate"):
        write(tmp_path, command="diagnose", force=True)
    write(tmp_path, command="diagnose", files=["diagnosis.json"])
    write(tmp_path, force=True)
    assert json.loads((tmp_path / MANIFEST).read_text())["files"].keys() == {*FILES, "diagnosis.json"}


def test_a_link_is_not_followed(tmp_path):
    (tmp_path / "elsewhere").write_text("mine")
    (tmp_path / "result.json").symlink_to(tmp_path / "elsewhere")
    with pytest.raises(OutputError, match="not its own"):
        write(tmp_path, force=True)
    assert (tmp_path / "elsewhere").read_text() == "mine"


def test_nothing_is_written_into_what_is_read(tmp_path):
    (tmp_path / "data").mkdir()
    with pytest.raises(OutputError, match="is an input of this command"):
        write(tmp_path / "data" / ".." / "data", inputs=[tmp_path / "data"])
    with pytest.raises(OutputError, match="is an input of this command or is inside one"):
        write(tmp_path / "data" / "result", inputs=[tmp_path / "data"])
    assert not list((tmp_path / "data").iterdir())


def test_a_command_that_fails_leaves_no_trace_and_one_that_is_stopped_owns_what_it_left(tmp_path):
    with pytest.raises(ZeroDivisionError), results_in(tmp_path, command="calibrate", files=FILES):
        raise ZeroDivisionError
    assert not list(tmp_path.iterdir())
    with pytest.raises(ZeroDivisionError), results_in(tmp_path / "new", command="calibrate", files=FILES):
        raise ZeroDivisionError
    assert not (tmp_path / "new").exists()
    with pytest.raises(KeyboardInterrupt):
        stopped(tmp_path)
    write(tmp_path, state=["state"])


def test_what_a_killed_command_left_is_its_own(tmp_path):
    child = multiprocessing.get_context("spawn").Process(target=killed_while_writing, args=(tmp_path,))
    child.start()
    child.join()
    assert (tmp_path / "result.json").read_text() == "half"
    write(tmp_path, force=True)


def stopped(folder):
    with results_in(folder, command="calibrate", files=FILES, state=["state"]):
        (folder / "state").write_text("half")
        raise KeyboardInterrupt


def killed_while_writing(folder):
    with results_in(folder, command="calibrate", files=FILES):
        (folder / "result.json").write_text("half")
        os.kill(os.getpid(), signal.SIGKILL)


def test_two_commands_do_not_write_into_one_folder(tmp_path):
    with (
        results_in(tmp_path, command="compare", files=()),
        pytest.raises(OutputError, match="Another robolaser command is writing"),
    ):
        write(tmp_path)
    write(tmp_path)


@pytest.mark.parametrize("manifest", ["", "{}", "[1]", '{"files": 3}', '{"files": {"result.json": 1}}', "[" * 100_000])
def test_a_broken_manifest_owns_nothing(tmp_path, manifest):
    write(tmp_path)
    (tmp_path / MANIFEST).write_text(manifest)
    with pytest.raises(OutputError, match="not its own"):
        write(tmp_path, force=True)
