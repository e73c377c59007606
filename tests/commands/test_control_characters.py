"""What data say never reaches a terminal as a command to it."""

import io
import json

import pytest
from rich.console import Console

from robolaser.cli import main
from robolaser.report.console import print_document
from robolaser.report.document import Document
from robolaser.report.printable import printable

TITLE = "\x1b]0;OWNED\x07\x1b[31mred\x9b2J\u202e"


def test_control_characters_are_written_out_and_the_rest_stays():
    assert printable("a\tb\nÄ π") == "a\tb\nÄ π"
    assert printable(TITLE) == r"\u001b]0;OWNED\u0007\u001b[31mred\u009b2J\u202e"


def test_json_says_the_same_with_them_written_out():
    said = {"name": "\x9b2J\x7f"}
    assert json.loads(printable(json.dumps(said, ensure_ascii=False))) == said


@pytest.mark.parametrize("terminal", [True, False])
def test_a_summary_keeps_its_colours_and_nobody_elses(terminal):
    file = io.StringIO()
    document = Document(f"name {TITLE}", "", "", "", "", [], [])
    print_document(document, console=Console(file=file, force_terminal=terminal, color_system="standard"))
    said = file.getvalue()
    assert "\x1b]0;" not in said
    assert "\x1b[31m" not in said
    assert "\\u001b]0;OWNED" in said
    assert ("\x1b[1m" in said) == terminal


@pytest.fixture
def hostile(tmp_path):
    folder = tmp_path / "cell"
    typed = ["simulate", "--robot", "scorbot_er7", "--poses", "10", "--points", "5", "--output", str(folder), "--quiet"]
    assert main(typed) == 0
    toml = folder / "dataset.toml"
    text = toml.read_text()
    first = next(line for line in text.splitlines() if line.startswith("name"))
    toml.write_text(text.replace(first, r'name = "\u001b]0;OWNED\u0007\u001b[31mred"'))
    return folder


def test_a_name_in_a_data_set_commands_no_terminal_and_no_page(hostile, tmp_path, capsys):
    assert main(["calibrate", str(hostile), "--output", str(tmp_path / "result")]) == 0
    said = capsys.readouterr()
    assert "\x1b" not in said.out + said.err + (tmp_path / "result" / "report.html").read_text()
    assert "\\u001b]0;OWNED" in said.out


def test_a_key_of_a_megabyte_is_shown_in_a_line(hostile, capsys):
    toml = hostile / "dataset.toml"
    toml.write_text(f"{'a' * 1_000_000} = 1\n{toml.read_text()}")
    assert main(["check", str(hostile)]) == 1
    assert len(capsys.readouterr().err) < 1000


def test_what_is_checked_commands_no_terminal(hostile, capsys):
    assert main(["check", str(hostile)]) == 0
    said = capsys.readouterr()
    assert "\x1b" not in said.out + said.err
    assert "\\u001b]0;OWNED" in said.out


@pytest.mark.parametrize("file", ["poses.csv", "points.csv", "dataset.toml"])
def test_a_bad_cell_or_key_commands_no_terminal(hostile, tmp_path, capsys, file):
    path = hostile / file
    lines = path.read_text().splitlines()
    if file == "dataset.toml":
        lines.append('"\\u001b[31mkey" = 1')
    else:
        lines[1] = ",".join(["\x1b[31mp", *lines[1].split(",")[1:-1], "\x1b]0;x\x07"])
    path.write_text("\n".join(lines) + "\n")
    assert main(["calibrate", str(hostile), "--output", str(tmp_path / "result")]) == 1
    said = capsys.readouterr()
    assert said.err
    assert "\x1b" not in said.out + said.err
