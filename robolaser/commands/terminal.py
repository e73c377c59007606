"""What a command shows: its progress, its warnings and its result, as text or as JSON."""

import json
import sys
from collections.abc import Callable, Iterator, Mapping, Sequence
from contextlib import contextmanager
from dataclasses import dataclass
from typing import final

from cyclopts import Group, Parameter

from robolaser.report.printable import printable


def say(text: str) -> None:
    """Print text on standard output; control characters in it are written out."""
    print(printable(text), flush=True)


def aligned(rows: Sequence[Sequence[str]], side: Callable[[str, int], str] = str.ljust) -> list[str]:
    """Lines of a table: the first column to the left, the others to the `side`."""
    widths = [max(map(len, column)) for column in zip(*rows, strict=True)]
    justified = [[row[0].ljust(widths[0]), *map(side, row[1:], widths[1:])] for row in rows]
    return ["  ".join(row).rstrip() for row in justified]


@final
@Parameter(name="*", group=Group("Terminal", sort_key=2))
@dataclass(frozen=True)
class Terminal:
    """What a command shows.

    Attributes:
        json: Print nothing but the result, as JSON, on standard output.
        quiet: Print warnings and errors only.
    """

    json: bool = False
    quiet: bool = False

    def print(self, text: str) -> None:
        """Print a part of what people read."""
        if not (self.json or self.quiet):
            say(text)

    def show(self, result: Mapping[str, object] | str, summary: Callable[[], None]) -> None:
        """Print the result once: as JSON, or as what people read.

        Args:
            result: What is written as JSON, or the text of it.
            summary: Prints it for people.
        """
        if self.json:
            say(result.rstrip() if isinstance(result, str) else json.dumps(result, indent=1))
        elif not self.quiet:
            summary()

    def warn(self, *messages: str) -> None:
        """Say on standard error what is odd, but no error."""
        for message in messages:
            print(f"warning: {printable(message)}", file=sys.stderr)

    @contextmanager
    def progress(self) -> Iterator[Callable[[str, float], None]]:
        """Show how far a long command is, on a terminal and only there.

        Yields:
            A function of what is being done and of the share, 0 to 1, that is done.
        """
        if self.quiet:
            yield lambda what, share: None
            return
        from robolaser.report.progress_bar import progress_bar

        with progress_bar() as tell:
            yield tell


TERMINAL = Terminal()  # text on standard output, progress on a terminal
