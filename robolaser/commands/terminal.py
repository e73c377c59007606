"""What a command shows: its progress, its warnings and its result, as text or as JSON."""

import json
import sys
import time
from collections.abc import Callable, Iterator, Mapping
from contextlib import contextmanager
from dataclasses import dataclass
from typing import final

from cyclopts import Group, Parameter

from robolaser.report.printable import printable

PATIENCE_S = 2.0  # what takes longer shows its progress


def say(text: str) -> None:
    """Print text on standard output; control characters in it are written out."""
    print(printable(text), flush=True)


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

    def warn(self, message: str) -> None:
        """Say on standard error what is odd, but no error."""
        print(f"warning: {printable(message)}", file=sys.stderr)

    @contextmanager
    def progress(self) -> Iterator[Callable[[str, float], None]]:
        """Show how far a long command is, on a terminal and only there.

        Yields:
            A function of what is being done and of the share, 0 to 1, that is done.
        """
        if self.quiet or not sys.stderr.isatty():
            yield lambda what, share: None
            return
        from rich.console import Console
        from rich.markup import escape
        from rich.progress import BarColumn, Progress, TaskProgressColumn, TextColumn, TimeElapsedColumn

        columns = (BarColumn(30), TaskProgressColumn(), TimeElapsedColumn(), TextColumn("{task.description}"))
        bar = Progress(*columns, console=Console(stderr=True), transient=True, refresh_per_second=5)
        task = bar.add_task("", total=1.0)
        began = time.monotonic()

        def tell(what: str, share: float) -> None:
            bar.update(task, description=escape(printable(what)), completed=share)
            if time.monotonic() - began > PATIENCE_S and not bar.live.is_started:
                bar.start()

        try:
            yield tell
        finally:
            bar.stop()


TERMINAL = Terminal()  # text on standard output, progress on a terminal
