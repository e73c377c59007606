"""Where summaries are printed: in colour on a terminal, as plain text anywhere else."""

from collections.abc import Iterator

from rich import box
from rich.console import Console, ConsoleOptions, ConsoleRenderable, RenderHook
from rich.segment import Segment
from rich.table import Table

from robolaser.report.printable import printable

WIDE = 160  # letters in a line of text that goes to a file


def plain_unless_terminal(console: Console | None) -> Console:
    """The console to print to: the given one or standard output, without colours and wide if it is no terminal."""
    out = console or Console(highlight=False)
    if not out.is_terminal:
        out = Console(file=out.file, highlight=False, width=WIDE, color_system=None)
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


def table(*headings: str) -> Table:
    """A table with these columns, none of which is broken."""
    made = Table(box=box.SIMPLE_HEAD, padding=(0, 1), show_edge=False)
    for heading in headings:
        made.add_column(heading, no_wrap=True)
    return made
