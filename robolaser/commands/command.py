"""What a command is, and what commands have in common: folders, progress and messages."""

import argparse
import shlex
import sys
import tempfile
import time
from abc import ABC, abstractmethod
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import ClassVar

from robolaser.errors import FileUnwritable

PATIENCE_S = 2.0  # what takes longer shows how far it is


class Command(ABC):
    """One word after `robolaser`, and what it does."""

    name: ClassVar[str]
    summary: ClassVar[str]

    @abstractmethod
    def declare(self, parser: argparse.ArgumentParser) -> None:
        """Say what can be given to it."""

    @abstractmethod
    def run(self, args: argparse.Namespace) -> None:
        """Do it.

        Raises:
            RobolaserError: What was wrong, for the user.
        """


def make_folder(folder: Path) -> None:
    """Create a folder and those above it, and see that files can be put into it before any work is done.

    Raises:
        FileUnwritable: It cannot be, or they cannot.
    """
    try:
        folder.mkdir(parents=True, exist_ok=True)
        tempfile.TemporaryFile(dir=folder).close()
    except OSError as error:
        raise FileUnwritable(folder, error.strerror or str(error)) from None


def warn(message: str) -> None:
    """Say what is odd, but no error."""
    print(f"warning: {message}", file=sys.stderr)


def command_line() -> str:
    """What was typed, ready to be typed again."""
    return shlex.join(["robolaser", *sys.argv[1:]])


@contextmanager
def progress_bar() -> Iterator[Callable[[str, float], None]]:
    """Show how far a long command is, on a terminal and only there."""
    if not sys.stderr.isatty():
        yield lambda what, share: None
        return
    began = time.monotonic()
    shown = [0.0]

    def tell(what: str, share: float) -> None:
        now = time.monotonic()
        if now - began > PATIENCE_S and now - shown[0] > 0.1:
            filled = int(30 * share)
            sys.stderr.write(
                f"\r\x1b[K{what:<22} {'█' * filled}{'░' * (30 - filled)} {share:4.0%} {now - began:5.0f} s"
            )
            sys.stderr.flush()
            shown[0] = now

    try:
        yield tell
    finally:
        if shown[0]:
            sys.stderr.write("\r\x1b[K")
            sys.stderr.flush()
