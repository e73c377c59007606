"""Where summaries are printed: in colour on a terminal, as plain text anywhere else."""

from rich import box
from rich.console import Console
from rich.table import Table

WIDE = 160  # letters in a line of text that goes to a file


def plain_unless_terminal(console: Console | None) -> Console:
    """The console to print to: the given one or standard output, without colours and wide if it is no terminal."""
    out = console or Console(highlight=False)
    return out if out.is_terminal else Console(file=out.file, highlight=False, width=WIDE, color_system=None)


def table(*headings: str) -> Table:
    """A table with these columns, none of which is broken."""
    made = Table(box=box.SIMPLE_HEAD, padding=(0, 1), show_edge=False)
    for heading in headings:
        made.add_column(heading, no_wrap=True)
    return made
