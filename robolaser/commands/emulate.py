"""robolaser emulate: a cell that is not there."""

import argparse
from typing import ClassVar, final

from robolaser.commands.command import Command
from robolaser.emulator.serving import declare, serve


@final
class Emulate(Command):
    """Serves an arm on a pseudo terminal, and a camera, until it is ended."""

    name: ClassVar[str] = "emulate"
    summary: ClassVar[str] = "serve a cell that is not there: its arm's line and its camera, with faults on demand"

    def declare(self, parser: argparse.ArgumentParser) -> None:
        """Say what can be given to it."""
        declare(parser)

    def run(self, args: argparse.Namespace) -> None:
        """Print where arm and camera are, as one line of JSON, and serve."""
        serve(args)
