"""A report as a document: sections of blocks, shown by a page, a terminal or a notebook."""

from collections.abc import Sequence
from dataclasses import dataclass
from typing import final

from robolaser.report.chart import Chart
from robolaser.report.scene import Scene


@final
@dataclass(frozen=True)
class Text:
    """A paragraph; text between backticks is code."""

    text: str  # its sentences
    kind: str = ""  # "" or "quiet", for optional reading
    printed: bool = False  # does the terminal show it?


@final
@dataclass(frozen=True)
class Notes:
    """A list of sentences."""

    rows: Sequence[str]  # the sentences
    kind: str = "notes"  # "notes", "warnings", or "steps", which are numbered
    printed: int = 0  # how many of them the terminal shows


@final
@dataclass(frozen=True)
class Figure:
    """One of a few numbers that matter most."""

    kind: str  # "held-out", "noise", "fitted" or "", for its colour
    label: str  # what it is
    value: str  # with its unit
    remark: str  # how to read it
    share: float | None = None  # of the largest one, in per cent; None where there is no bar


@final
@dataclass(frozen=True)
class Figures:
    """The numbers that matter most, which the terminal shows too."""

    rows: Sequence[Figure]


@final
@dataclass(frozen=True)
class TableCell:
    """A cell of a table."""

    text: str = ""  # may have several lines
    below: Sequence[str] = ()  # lines in small type
    note: str = ""  # a caveat
    order: float | None = None  # by which a column is sorted; None: by the text
    share: float | None = None  # length of a bar [%]; None for none
    line: int | None = None  # number of a line's colour, see `chart.LINES`; -1 is grey, None is no swatch
    lean: float | None = None  # from -100 to 100, for the colour of a matrix's cell
    hint: str = ""  # tooltip
    link: str = ""  # file beside the page that the text leads to; "" for none


@final
@dataclass(frozen=True)
class Column:
    """A column of a table."""

    title: str  # with unit, if its cells have none
    kind: str = "text"  # "name", "number", "text", or "wide", which takes a line of its own on a phone
    width: int = 0  # of the page [%]; 0: as its cells need
    brief: str | None = None  # its heading on the terminal; None: it is not shown there


@final
@dataclass(frozen=True)
class Table:
    """Rows that a reader may sort; the first cell of each names it."""

    columns: Sequence[Column]  # from the left
    rows: Sequence[Sequence[TableCell | str]]  # texts, or cells with more content
    title: str = ""  # above it
    note: str = ""  # below it
    fold: int = 40  # more rows than this are collapsed
    printed: int = 0  # how many rows the terminal shows
    kind: str = ""  # "" or "matrix", each row against each column

    @property
    def cells(self) -> list[list[TableCell]]:
        """All rows as cells."""
        return [[TableCell(one) if isinstance(one, str) else one for one in row] for row in self.rows]


@final
@dataclass(frozen=True)
class Charts:
    """Charts side by side."""

    charts: Sequence[Chart]


Content = Text | Notes | Figures | Table | Charts | Scene


@final
@dataclass(frozen=True)
class Section:
    """Blocks under a heading."""

    title: str
    blocks: Sequence[Content]


@final
@dataclass(frozen=True)
class Document:
    """A report: first the answer, then the doubt, then the evidence."""

    name: str  # of its subject
    what: str  # what was done with it, in a word
    setting: str  # sensor, robot, and amount of data
    lead: str  # the answer in a sentence
    sense: str  # what it means
    head: Sequence[Content]  # blocks that belong to the answer
    sections: Sequence[Section]  # the doubt and the evidence
    verdict: str = ""  # of a diagnosis, as its JSON has it
    footer: str = ""  # origin and licence of the data
    prints_lead: bool = False  # does the terminal begin with the answer, rather than with its figures?

    @property
    def blocks(self) -> list[Content]:
        """All blocks in their order."""
        return [*self.head, *(block for section in self.shown for block in section.blocks)]

    @property
    def shown(self) -> list[Section]:
        """The sections with content, without their empty blocks."""
        sections = [Section(one.title, [block for block in one.blocks if has_rows(block)]) for one in self.sections]
        return [section for section in sections if section.blocks]


def has_rows(block: Content) -> bool:
    """Does a block have content?"""
    return not isinstance(block, Notes | Figures | Table) or bool(block.rows)


def charts(made: Sequence[Chart | None]) -> list[Content]:
    """A block of the charts with content; none where none has."""
    shown = [one for one in made if one is not None]
    return [Charts(shown)] if shown else []
