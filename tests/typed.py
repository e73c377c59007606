"""Commands as the docs show them, run in the tests' process, which has its imports already."""

import runpy
import shlex
from contextlib import chdir, redirect_stderr, redirect_stdout
from io import StringIO
from pathlib import Path

import pytest
from run_code_blocks import HELP_WIDTH, WIDTH, run_shell

from robolaser.cli import main


def run_typed(command: str, folder: Path, *, expected: int) -> str:
    """The output of a command in a folder, also of a Python script; other programs' commands are run by a shell."""
    program, *words = shlex.split(command.replace("\\\n", ""))
    output = StringIO()
    if program == "python":
        with chdir(folder), redirect_stdout(output):
            runpy.run_path(*words, run_name="__main__")
        return output.getvalue()
    if program != "robolaser":
        return run_shell(command, folder, expected=expected)
    with pytest.MonkeyPatch.context() as patch, chdir(folder), redirect_stdout(output), redirect_stderr(output):
        patch.setenv("COLUMNS", HELP_WIDTH if "--help" in words else WIDTH)
        assert main(words) == expected, output.getvalue()
    return output.getvalue()
