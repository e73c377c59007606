"""The command line: reads what was typed, lets one command run, and turns errors into sentences."""

import argparse
import os
import sys
from collections.abc import Sequence
from importlib.metadata import version

from robolaser.commands.calibrate import Calibrate
from robolaser.commands.command import Command
from robolaser.commands.extract import Extract
from robolaser.commands.listing import List
from robolaser.commands.simulate import Simulate
from robolaser.errors import Interrupted, RobolaserError

COMMANDS: tuple[Command, ...] = (Calibrate(), Extract(), Simulate(), List())
DATA_SAID_NO = 1


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
        0: done. 1: the data or the robot said no, see standard error. Wrong usage exits with 2.
    """
    args = parser().parse_args(argv)
    try:
        args.run(args)
        sys.stdout.flush()
    except RobolaserError as error:
        print(f"robolaser: {error}", file=sys.stderr)
        return DATA_SAID_NO
    except KeyboardInterrupt:
        print(f"robolaser: {Interrupted(None)}", file=sys.stderr)
        return DATA_SAID_NO
    except BrokenPipeError:
        os.dup2(os.open(os.devnull, os.O_WRONLY), sys.stdout.fileno())
        return DATA_SAID_NO
    return 0
