"""The command line: reads what was typed, lets one command run, and turns errors into sentences."""

import argparse
import io
import os
import sys
from collections.abc import Sequence
from contextlib import suppress
from importlib.metadata import version

from robolaser.commands.calibrate import Calibrate
from robolaser.commands.challenge import Challenge
from robolaser.commands.command import Command
from robolaser.commands.compare import Compare
from robolaser.commands.diagnose import Diagnose
from robolaser.commands.emulate import Emulate
from robolaser.commands.extract import Extract
from robolaser.commands.listing import List
from robolaser.commands.record import Record
from robolaser.commands.scan import Scan
from robolaser.commands.simulate import Simulate
from robolaser.commands.view import View
from robolaser.errors import Interrupted, RobolaserError, SystemSaidNo, WrongUsage

COMMANDS: tuple[Command, ...] = (
    Calibrate(),
    Diagnose(),
    Compare(),
    Extract(),
    Simulate(),
    Record(),
    Emulate(),
    Scan(),
    View(),
    Challenge(),
    List(),
)
DATA_SAID_NO = 1
WRONG_USAGE = 2


def parser() -> argparse.ArgumentParser:
    """What can be typed."""
    top = argparse.ArgumentParser(
        prog="robolaser",
        description="Calibrate robot-mounted laser scanners, and say why the robot does not do what the model says.",
    )
    top.add_argument("--version", action="version", version=f"robolaser {version('robolaser')}")
    words = top.add_subparsers(metavar="COMMAND", required=True)
    for command in COMMANDS:
        below = words.add_parser(command.name, help=command.summary, description=command.summary.capitalize() + ".")
        command.declare(below)
        below.set_defaults(run=command.run)
    return top


def main(argv: Sequence[str] | None = None) -> int:
    """Run one command.

    Returns:
        0: done. 1: the data or the robot said no, see standard error. 2: wrong usage.
    """
    _speak_plainly()
    args = parser().parse_args(argv)
    try:
        args.run(args)
        sys.stdout.flush()
    except RobolaserError as error:
        print(f"robolaser: {error}", file=sys.stderr)
        return WRONG_USAGE if isinstance(error, WrongUsage) else DATA_SAID_NO
    except KeyboardInterrupt:
        print(f"robolaser: {Interrupted(None)}", file=sys.stderr)
        return DATA_SAID_NO
    except BrokenPipeError:
        _write_nowhere()
        return DATA_SAID_NO
    except OSError as error:
        print(f"robolaser: {SystemSaidNo(error)}", file=sys.stderr)
        _write_nowhere()
        return DATA_SAID_NO
    return 0


def _speak_plainly() -> None:
    """Let a terminal or file that lacks a letter show "?" instead, and one that was closed swallow everything."""
    sys.stdout = sys.stdout or open(os.devnull, "w", encoding="utf-8")  # noqa: SIM115 - open as long as the process
    sys.stderr = sys.stderr or open(os.devnull, "w", encoding="utf-8")  # noqa: SIM115
    for stream in (sys.stdout, sys.stderr):
        if isinstance(stream, io.TextIOWrapper):
            stream.reconfigure(errors="replace")


def _write_nowhere() -> None:
    """Send to nowhere what is still to be written when Python ends."""
    with suppress(io.UnsupportedOperation):  # a stream in memory has no descriptor
        os.dup2(os.open(os.devnull, os.O_WRONLY), sys.stdout.fileno())
