"""The report of a comparison, as a page and in twenty lines on the terminal."""

import re
from collections.abc import Sequence
from dataclasses import replace

from robolaser.benchmark.result import BenchmarkResult
from robolaser.benchmark.standings.answer import names
from robolaser.benchmark.standings.table import Standings
from robolaser.report.comparison import tables, words
from robolaser.report.comparison.charts import numbers, solved
from robolaser.report.document import Block, Cell, Column, Document, Section, Table, Text, charts

LONG = 140
"""Letters of a sentence that is too long for large type."""
MOST_PRINTED, FEWEST_PRINTED = 12, 4
"""Algorithms that the terminal shows of all families together, and of each."""
MOST_LINES = 8
"""Problems, failures and refusals that the terminal shows."""

NOISY = "noisy: runs are ranked by their returned candidates, re-evaluated"


def document(
    comparison: BenchmarkResult, judged: Sequence[Standings], *, command: str = "", brief: bool = False
) -> Document:
    """The report.

    Args:
        comparison: What was run.
        judged: The standings of each family of problems.
        command: What to type to repeat it.
        brief: Leave out what only a page shows.
    """
    shown = judged if comparison.runs else ()
    lead, sense = _parted(_unbroken(shown[0].order.answer if shown else "No run has finished yet."))
    sections = [_family(comparison, one, i, brief=brief) for i, one in enumerate(shown)]
    sections += [] if brief else [section for one in shown for section in _problems(comparison, one)]
    sections += _conditions(comparison, shown)
    if not brief:
        scopes = [("Limitations", scope) for scope in dict.fromkeys(one.scope for one in shown)]
        sections.append(Section("How it was measured", [_terms(words.measured(comparison), "Condition", "Value")]))
        sections.append(Section("How to read it", [_terms([*words.READING, *scopes], "Term", "Meaning")]))
    return Document(
        names([problem.name for problem in comparison.problems]),
        "compared",
        words.setting(comparison),
        lead,
        sense,
        [],
        sections,
        command=command,
        prints_lead=True,
    )


def _unbroken(text: str) -> str:
    """Numbers and what follows them on one line."""
    return re.sub(r"(?<=\d) (?=[%×])|(?<=p [<=]) | (?=[<=] \d)", "\u00a0", text)


def _parted(answer: str) -> tuple[str, str]:
    """The first thing that an answer says, and the rest."""
    lead, _, rest = answer.partition(". ")
    if len(lead) <= LONG or ": " not in lead:
        return f"{lead.rstrip('.')}.", rest
    lead, _, rest = answer.partition(": ")
    return f"{lead}:", rest


def _family(comparison: BenchmarkResult, standings: Standings, number: int, *, brief: bool) -> Section:
    title = words.FAMILIES[standings.family]
    most = max(FEWEST_PRINTED, MOST_PRINTED // len(comparison.families))
    table = tables.standing_table(comparison, standings, numbers(standings), most)
    blocks: list[Block] = [] if number == 0 else [Text(_unbroken(standings.order.answer), printed=True)]
    blocks.append(replace(table, title=title) if brief and len(comparison.families) > 1 else table)
    blocks.append(tables.effect_table(standings))
    if not brief:
        blocks += charts([solved(comparison, standings, f"Targets reached by evaluations: {title.lower()}")])
        blocks += [tables.pairwise_matrix(standings.order)] if len(standings.by_problem) > 1 else []
    return Section(title, blocks)


def _conditions(comparison: BenchmarkResult, judged: Sequence[Standings]) -> list[Section]:
    """Problems with their targets, and what failed or could not be run."""
    failed = Table(
        [Column("Algorithm", "name", brief="failed"), Column("Runs", "number", brief="runs"),
         Column("Reason", "wide", brief="reason"), Column("Problems", "wide")],
        [(name, Cell(str(n), order=n), reason, where) for name, reason, n, where in tables.failure_rows(comparison)],
        printed=MOST_LINES,
    )  # fmt: skip
    refused = Table(
        [Column("Algorithm", "name", brief="not run"), Column("Problem", "wide", brief="on"),
         Column("Reason", "wide", brief="reason")],
        tables.refusal_rows(comparison),
        printed=MOST_LINES,
    )  # fmt: skip
    return [
        Section("Problems", [_problem_table(comparison, judged)]),
        Section("Runs that failed", [failed]),
        Section("What could not be run", [refused]),
    ]


def _problems(comparison: BenchmarkResult, standings: Standings) -> list[Section]:
    sections, several = [], len(standings.by_problem) > 1
    for on in standings.by_problem:
        problem = next(one for one in comparison.problems if one.name == on.problem)
        blocks: list[Block] = [Text(problem.title, "quiet")]
        blocks += [Text(_unbroken(on.order.answer))] if several else []
        blocks.append(tables.result_table(problem, on, standings.tolerance, numbers(standings)))
        blocks.append(tables.pairwise_matrix(on.order))
        sections.append(Section(problem.name, blocks))
    return sections


def _terms(items: Sequence[tuple[str, str]], *titles: str) -> Table:
    return Table([Column(titles[0], "name", 20), Column(titles[1], "wide")], items)


def _problem_table(comparison: BenchmarkResult, judged: Sequence[Standings]) -> Table:
    tolerance = {one.family: one.tolerance for one in judged}
    rows = [
        (
            Cell(one.name, below=[one.title], note=NOISY if one.noisy else ""),
            Cell(str(one.dimension), order=one.dimension),
            f"{one.budget:,}",
            words.target(one, tolerance[one.family]) if one.family in tolerance else "",
        )
        for one in comparison.problems
    ]
    columns = [Column("Problem", "name", 30, "problem"), Column("Variables"), Column("Budget")]
    return Table([*columns, Column("Target", "wide", brief="target")], rows, printed=MOST_LINES)
