"""A document in a few lines: in colour on a terminal, as plain text anywhere else."""

import io
import os
from pathlib import Path

from rich import box
from rich.console import Console
from rich.table import Column as Heading
from rich.table import Table as Grid
from rich.text import Text as Line

from robolaser.report.document import Content, Document, Figures, Notes, Table, Text
from robolaser.report.printable import printable

WIDE = 160  # letters in a line of text that goes to a file, unless COLUMNS says otherwise
LEAST_VALUE = 10  # letters of a figure's column
STYLES = {"held-out": "bold", "fitted": "dim"}


def _plain_unless_terminal(console: Console | None) -> Console:
    """The console to print to: the given one or standard output, without colours if it is no terminal."""
    out = console or Console(highlight=False)
    if not out.is_terminal:
        columns = os.environ.get("COLUMNS", "")
        width = int(columns) if columns.isdecimal() and int(columns) else WIDE
        out = Console(
            file=out.file, highlight=False, width=width, color_system=None,
            force_terminal=False, force_jupyter=False,
        )  # fmt: skip
    return out


def _line(text: str, style: str = "") -> Line:
    """Text from data without markup, control characters escaped."""
    return Line(printable(text), style)


def print_document(document: Document, folder: Path | None = None, *, console: Console | None = None) -> None:
    """Print a report's answer, figures, the first rows of its important tables, and the folder of its page.

    To standard output unless another console is given; plain text unless on a terminal.
    """
    out = _plain_unless_terminal(console)
    out.print(_line(f"{document.name}: {document.setting}", "bold"))
    if document.prints_lead:
        out.print(_line(f"{document.lead} {document.sense}".strip()))
    for block in document.head:
        _print(block, out)
    if document.sense and not document.prints_lead:
        out.print(_line(document.sense))
    for block in (block for section in document.shown for block in section.blocks):
        _print(block, out)
    if folder is not None:  # its path is never wrapped, so that it can be copied
        out.print(_line(f"Look at {folder / 'report.html'}"), soft_wrap=True)


def printed(document: Document) -> str:
    """The printed report as plain text."""
    text = io.StringIO()
    print_document(document, console=Console(file=text, force_terminal=False, force_jupyter=False))
    return text.getvalue()


def _print(block: Content, out: Console) -> None:
    match block:
        case Text(printed=True):
            out.print(_line(block.text, "dim" if block.kind else ""))
        case Notes():
            for item in block.rows[: block.printed]:
                out.print(_line(f"- {item}"))
            if (more := len(block.rows) - block.printed) > 0 and block.printed:
                out.print(_line(f"- and {more} more in the report", "dim"))
        case Figures():
            _print_figures(block, out)
        case Table() if block.printed:
            if block.title:
                out.print(_line(block.title, "bold"))
            out.print(_printed(block))


def _print_figures(figures: Figures, out: Console) -> None:
    label = 1 + max(len(row.label) for row in figures.rows)
    value = max(LEAST_VALUE, *(len(row.value) for row in figures.rows))
    for row in figures.rows:
        line = _line(f"  {row.label:<{label}} {row.value:>{value}}   ", STYLES.get(row.kind, ""))
        out.print(line + _line(row.remark, "dim"))


def _printed(block: Table) -> Grid:
    """Its first rows; cells with their first line and caveat. On narrow terminals the widest columns are wrapped."""
    headings = {i: column.brief for i, column in enumerate(block.columns) if column.brief is not None}
    shown, columns = list(headings), (Heading(_line(heading), overflow="fold") for heading in headings.values())
    made = Grid(*columns, box=box.SIMPLE_HEAD, padding=(0, 1), show_edge=False)
    for row in block.cells[: block.printed]:
        texts = [_line(row[i].text.partition("\n")[0]) for i in shown]
        notes = [_line(row[i].note.partition("\n")[0], "dim") for i in shown]
        made.add_row(
            *(_line("; " if text and note else "").join((text, note)) for text, note in zip(texts, notes, strict=True))
        )
    left = len(block.rows) - block.printed
    if left > 0:
        made.add_row(f"and {left} more", "in the report")
    return made
