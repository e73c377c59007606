"""A document in a few lines: in colour on a terminal, as plain text anywhere else."""

import os
from collections.abc import Iterator
from pathlib import Path

from rich import box
from rich.console import Console, ConsoleOptions, ConsoleRenderable, RenderHook
from rich.segment import Segment
from rich.table import Column as Heading
from rich.table import Table as Grid
from rich.text import Text

from robolaser.report.document import Block, Document, Figures, Notes, Table
from robolaser.report.document import Text as Paragraph
from robolaser.report.printable import printable

WIDE = 160  # letters in a line of text that goes to a file, unless COLUMNS says otherwise
LEAST_VALUE = 10  # letters of a figure's column
STYLES = {"held-out": "bold", "fitted": "dim"}
NAME = 24
"""Letters of a name that stay in a line."""


def plain_unless_terminal(console: Console | None) -> Console:
    """The console to print to: the given one or standard output, without colours if it is no terminal."""
    out = console or Console(highlight=False)
    if not out.is_terminal:
        columns = os.environ.get("COLUMNS", "")
        width = int(columns) if columns.isdecimal() and int(columns) else WIDE
        out = Console(
            file=out.file, highlight=False, width=width, color_system=None,
            force_terminal=False, force_jupyter=False,
        )  # fmt: skip
    out.push_render_hook(_Printable())
    return out


class _Printable(RenderHook):
    """Writes out control characters that come from data; rich's own are no part of the text."""

    def process_renderables(self, renderables: list[ConsoleRenderable]) -> list[ConsoleRenderable]:
        return [_PrintableText(renderable) for renderable in renderables]


class _PrintableText:
    def __init__(self, renderable: ConsoleRenderable) -> None:
        self._renderable = renderable

    def __rich_console__(self, console: Console, options: ConsoleOptions) -> Iterator[Segment]:
        for text, style, control in console.render(self._renderable, options):
            yield Segment(text if control else printable(text), style, control)


def table(*headings: str) -> Grid:
    """A table with these columns; where room is short, the widest are broken."""
    columns = (Heading(heading, overflow="fold") for heading in headings)
    return Grid(*columns, box=box.SIMPLE_HEAD, padding=(0, 1), show_edge=False)


def print_document(document: Document, out: Console) -> None:
    """Print a report's answer, figures and the first rows of the tables that matter.

    Args:
        document: The report.
        out: From `plain_unless_terminal`.
    """
    out.print(Text(f"{document.name}: {document.setting}", style="bold"))
    if document.prints_lead:
        out.print(Text(f"{document.lead} {document.sense}".strip()))
    for block in document.head:
        _print(block, out)
    if document.sense and not document.prints_lead:
        out.print(Text(document.sense))
    for section in document.sections:
        for block in section.blocks:
            _print(block, out)


def print_line(text: str, out: Console, style: str = "") -> None:
    """Print a sentence."""
    out.print(Text(text, style=style))


def print_page(folder: Path, out: Console) -> None:
    """Say where the page is; its path stays whole however narrow the lines are, to be copied."""
    out.print(Text(f"Look at {folder / 'report.html'}"), soft_wrap=True)


def _print(block: Block, out: Console) -> None:
    match block:
        case Paragraph(printed=True):
            out.print(Text(block.text, style="dim" if block.kind else ""))
        case Notes():
            for item in block.items[: block.printed]:
                out.print(Text(f"- {item}"))
        case Figures():
            print_figures(block, out)
        case Table() if block.printed and block.rows:
            if block.title:
                out.print(Text(block.title, style="bold"))
            out.print(_printed(block))


def print_figures(figures: Figures, out: Console) -> None:
    """Print figures, a line each."""
    label = 1 + max(len(row.label) for row in figures.rows)
    value = max(LEAST_VALUE, *(len(row.value) for row in figures.rows))
    for row in figures.rows:
        line = Text(f"  {row.label:<{label}} {row.value:>{value}}   ", style=STYLES.get(row.kind, ""))
        out.print(line + Text(row.remark, style="dim"))


def _printed(block: Table) -> Grid:
    """Its first rows; cells with their first line and caveat."""
    headings = {i: column.brief for i, column in enumerate(block.columns) if column.brief is not None}
    made, shown = table(*headings.values()), list(headings)
    for row in block.cells[: block.printed]:
        texts = [Text(row[i].text.partition("\n")[0]) for i in shown]
        notes = [Text(row[i].note.partition("\n")[0], style="dim") for i in shown]
        made.add_row(
            *(Text("; " if text and note else "").join((text, note)) for text, note in zip(texts, notes, strict=True))
        )
    left = len(block.rows) - block.printed
    if left > 0:
        made.add_row(f"and {left} more", "in the report")
    return made
