"""A report as a document: sections of blocks, which a page, a terminal and a notebook show each in their own way."""

from collections.abc import Sequence
from dataclasses import dataclass
from typing import final

from robolaser.report.chart import Chart
from robolaser.report.scene import Scene


@final
@dataclass(frozen=True)
class Text:
    """A paragraph; what stands between backticks is code.

    Attributes:
        text: Its sentences.
        kind: "" or "quiet", for what one need not read.
        printed: Does the terminal show it?
    """

    text: str
    kind: str = ""
    printed: bool = False


@final
@dataclass(frozen=True)
class Notes:
    """Sentences one below the other.

    Attributes:
        rows: The sentences.
        kind: "notes", "warnings", or "steps", which are numbered.
        printed: How many of them the terminal shows.
    """

    rows: Sequence[str]
    kind: str = "notes"
    printed: int = 0


@final
@dataclass(frozen=True)
class Figure:
    """One of a few numbers that matter most.

    Attributes:
        kind: "held-out", "noise", "fitted" or "", for its colour.
        label: What it is.
        value: With its unit.
        remark: How to read it.
        share: Of the largest one, in per cent; None where there is no bar.
    """

    kind: str
    label: str
    value: str
    remark: str
    share: float | None = None


@final
@dataclass(frozen=True)
class Figures:
    """The numbers that matter most, which the terminal shows too."""

    rows: Sequence[Figure]


@final
@dataclass(frozen=True)
class TableCell:
    """A cell of a table.

    Attributes:
        text: May have several lines.
        below: Lines in small letters.
        note: A caveat.
        order: By which a column is sorted; None: by the text.
        share: Length of a bar [%]; None for none.
        line: Number of a line's colour, see `chart.LINES`; -1 is grey, None is no swatch.
        lean: From -100 to 100, for the colour of a matrix's cell.
        hint: Said under the pointer.
        link: File beside the page that the text leads to; "" for none.
    """

    text: str = ""
    below: Sequence[str] = ()
    note: str = ""
    order: float | None = None
    share: float | None = None
    line: int | None = None
    lean: float | None = None
    hint: str = ""
    link: str = ""


@final
@dataclass(frozen=True)
class Column:
    """A column of a table.

    Attributes:
        title: With unit, if its cells have none.
        kind: "name", "number", "text", or "wide", which takes a line of its own on a phone.
        width: Of the page [%]; 0: as its cells need.
        brief: Its heading on the terminal; None: it is not shown there.
    """

    title: str
    kind: str = "text"
    width: int = 0
    brief: str | None = None


@final
@dataclass(frozen=True)
class Table:
    """Rows that a reader may sort; the first cell of each names it.

    Attributes:
        columns: From the left.
        rows: Texts, or cells with more to say.
        title: Above it.
        note: Below it.
        fold: More rows than this are folded away.
        printed: How many rows the terminal shows.
        kind: "" or "matrix", each row against each column.
    """

    columns: Sequence[Column]
    rows: Sequence[Sequence[TableCell | str]]
    title: str = ""
    note: str = ""
    fold: int = 40
    printed: int = 0
    kind: str = ""

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
    """A report: first the answer, then the doubt, then the evidence.

    Attributes:
        name: Of what it is about.
        what: What was done with it, in a word.
        setting: With which sensor and robot, and how much of it.
        lead: The answer in a sentence.
        sense: What it means.
        head: Blocks that belong to the answer.
        sections: The doubt and the evidence.
        verdict: Of a diagnosis, as its JSON has it.
        footer: Origin and licence of the data.
        prints_lead: Does the terminal begin with the answer, rather than with figures that say it?
    """

    name: str
    what: str
    setting: str
    lead: str
    sense: str
    head: Sequence[Content]
    sections: Sequence[Section]
    verdict: str = ""
    footer: str = ""
    prints_lead: bool = False

    @property
    def blocks(self) -> list[Content]:
        """All blocks in their order."""
        return [*self.head, *(block for section in self.shown for block in section.blocks)]

    @property
    def shown(self) -> list[Section]:
        """The sections that have something to say, with those of their blocks that have."""
        said = [Section(one.title, [block for block in one.blocks if has_rows(block)]) for one in self.sections]
        return [section for section in said if section.blocks]


def has_rows(block: Content) -> bool:
    """Does a block have something to say?"""
    return not isinstance(block, Notes | Figures | Table) or bool(block.rows)


def charts(made: Sequence[Chart | None]) -> list[Content]:
    """A block of the charts that have something to show; none where none has."""
    shown = [one for one in made if one is not None]
    return [Charts(shown)] if shown else []
