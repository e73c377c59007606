"""The command line: parses arguments, runs one command, and turns errors into messages."""

import io
import os
import re
import shlex
import sys
from collections.abc import Sequence
from contextlib import suppress
from itertools import pairwise

from cyclopts import App, CycloptsError, Group, Parameter

import robolaser
from robolaser.commands.calibrate import calibrate
from robolaser.commands.challenge import challenge
from robolaser.commands.check import check
from robolaser.commands.compare import compare
from robolaser.commands.diagnose import diagnose
from robolaser.commands.diff import diff
from robolaser.commands.emulate import emulate
from robolaser.commands.export import export
from robolaser.commands.extract import extract
from robolaser.commands.import_files import import_files
from robolaser.commands.listing import list_family
from robolaser.commands.new import new
from robolaser.commands.plan import plan
from robolaser.commands.record import record
from robolaser.commands.scan import scan
from robolaser.commands.simulate import simulate
from robolaser.commands.terminal import shown_default
from robolaser.commands.view import view
from robolaser.errors import RobolaserError, UsageError
from robolaser.report.printable import printable, short

LACKING = re.compile(r'^Command ".+" parameter (\S+) requires an argument')  # cyclopts' message for a missing value
USAGE = "Usage: robolaser"  # of commands with optional or repeated arguments: cyclopts calls these [ARGS]
DATA_SAID_NO = 1
WRONG_USAGE = 2


find = Group.create_ordered("Calibrate and diagnose")
data = Group.create_ordered("Get data")
use = Group.create_ordered("Use the result")
methods = Group.create_ordered("Compare and test methods")
app = App(
    "robolaser",
    help="Calibrate sensors on robots, and find out why the robot deviates from its model.",
    help_epilogue="Exit status 0: done. 1: the data, the robot or a file was at fault. 2: wrong usage.",
    help_format="plaintext",
    version_format="plaintext",
    version=lambda: f"robolaser {robolaser.__version__}",
    default_parameter=Parameter(negative=(), show_default=shown_default),
    group_commands=Group.create_ordered("More"),
    suppress_keyboard_interrupt=False,
)
app.command(calibrate, group=find)
app.command(diagnose, group=find)
app.command(simulate, group=data)
app.command(plan, group=data)
app.command(extract, group=data)
new.group = data
app.command(new)
app.command(record, group=data)
app.command(import_files, name="import", group=data, usage=f"{USAGE} import --output DATASET [OPTIONS] SOURCE...")
app.command(check, group=data)
app.command(scan, group=use, usage=f"{USAGE} scan --output CLOUD.ply [OPTIONS] CALIBRATION RECORDING [MORE...]")
app.command(view, group=use, usage=f"{USAGE} view [OPTIONS] DATASET [CALIBRATION]")
app.command(diff, group=use)
app.command(export, group=use)
app.command(compare, group=methods, usage=f"{USAGE} compare --output DIR [OPTIONS] [DATASETS...]")
challenge.group = methods
app.command(challenge)
app.command(emulate, group=methods)
app.command(list_family, name="list")
app.register_install_completion_command()


def main(argv: Sequence[str] | None = None) -> int:
    """Run one command.

    Returns:
        0: done. 1: the data, the robot or a file was at fault, see standard error. 2: wrong usage.
    """
    _speak_plainly()
    try:
        _run(list(sys.argv[1:] if argv is None else argv))
        sys.stdout.flush()
    except (CycloptsError, RobolaserError, KeyboardInterrupt, OSError) as error:
        if sentence := _sentence(error):
            print(f"robolaser: {printable(short(sentence))}", file=sys.stderr)
        if isinstance(error, OSError):
            _write_nowhere()
        return WRONG_USAGE if isinstance(error, (CycloptsError, UsageError)) else DATA_SAID_NO
    return 0


def _sentence(error: BaseException) -> str:
    """The message of an error; nothing if the output's reader is gone."""
    match error:
        case CycloptsError():
            command = " ".join(["robolaser", *(error.command_chain or ())])
            message = LACKING.sub(r"The value of \1 is missing", " ".join(str(error).split()))
            return f"{message} See `{command} --help`."
        case KeyboardInterrupt():
            return "Stopped. Nothing was written."
        case BrokenPipeError():
            return ""
        case OSError():
            what = "the output" if error.filename is None else error.filename
            return f"Cannot use {what}: {error.strerror or error}. Check the path, permissions and free disk space."
    return str(error)


def _run(tokens: Sequence[str]) -> None:
    """Run the given command.

    Raises:
        CycloptsError: The arguments have no meaning.
        RobolaserError: The command's own, or of an empty value.
    """
    for before, token in pairwise(["robolaser", *tokens]):
        if re.fullmatch(r"(--[\w-]+=)?", token):  # as a path it would be the current folder
            raise UsageError(f"The value after {token or before} is empty. Is a variable of your shell not set?")
    command, bound, passed_in = app.parse_args(tokens, print_error=False, exit_on_error=False)
    words, apps, _ = app.parse_commands(tokens)
    if apps[-1].default_command is None and not {"--help", "-h"} & set(tokens):
        raise UsageError(f"Name a command, see `{' '.join(['robolaser', *words])} --help`.")
    if "typed" in passed_in:
        bound.arguments["typed"] = shlex.join(["robolaser", *tokens])
    command(*bound.args, **bound.kwargs)


def _speak_plainly() -> None:
    """Let a terminal or file that lacks a letter show "?" instead, a closed one swallow all, and OpenCV be silent."""
    sys.stdout = sys.stdout or open(os.devnull, "w", encoding="utf-8")  # noqa: SIM115 - open as long as the process
    sys.stderr = sys.stderr or open(os.devnull, "w", encoding="utf-8")  # noqa: SIM115
    for stream in (sys.stdout, sys.stderr):
        if isinstance(stream, io.TextIOWrapper):
            stream.reconfigure(errors="replace")
    os.environ.setdefault("OPENCV_LOG_LEVEL", "SILENT")  # a damaged image or a lost camera has its own message


def _write_nowhere() -> None:
    """Discard output that Python still has to write at exit."""
    with suppress(io.UnsupportedOperation):  # a stream in memory has no descriptor
        os.dup2(os.open(os.devnull, os.O_WRONLY), sys.stdout.fileno())
