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
MOST_LINES, LONGEST = 8, 90
"""Lines of targets, of notes and of failures on the terminal, and letters of a reason."""


def document(
    comparison: BenchmarkResult, judged: Sequence[Standings], *, command: str = "", brief: bool = False
) -> Document:
    """The report.

    Args:
        comparison: What was run.
        judged: The standings of each family of problems.
        command: What to type to repeat it.
        brief: For the terminal: without charts and evidence, with the targets in words.
    """
    shown = judged if comparison.runs else ()
    lead, sense = _parted(_unbroken(shown[0].order.answer if shown else "No run has finished yet."))
    families = [_family(comparison, one, i, brief=brief) for i, one in enumerate(shown)]
    return Document(
        names([problem.name for problem in comparison.problems]),
        "compared",
        words.setting(comparison),
        lead,
        sense,
        [],
        [*families, _remarks(comparison, shown)] if brief else [*families, *_evidence(comparison, shown)],
        tag=(words.missing(comparison), "unexplained"),
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


def _remarks(comparison: BenchmarkResult, judged: Sequence[Standings]) -> Section:
    """What the terminal says besides: how far it has come, targets, notes and failures, not too many of each."""
    knowing = [name for name in comparison.solvers if name in comparison.know_budget]
    noisy = [one.name for one in comparison.problems if one.noisy]
    aims = [line for one in judged for line in words.aims(comparison, one)]
    notes = [f"{', '.join(knowing)}: searches differently with another budget."] if knowing else []
    notes += [f"{name} is noisy: runs are ranked by their returned candidates, re-evaluated." for name in noisy]
    failures = [
        f"{name}: {count} {'run' if count == 1 else 'runs'} failed, {_short(reason)}"
        for name, reason, count, _ in tables.failure_rows(comparison)
    ]
    failures += [
        f"{name} was not run on {where}: {_short(why)}" for name, where, why in tables.refusal_rows(comparison)
    ]
    missing = words.missing(comparison)
    blocks: list[Block] = [Text(missing, printed=True)] if missing else []
    for lines in (aims, notes, failures):
        more = [f"and {len(lines) - MOST_LINES} more, see the report"] if len(lines) > MOST_LINES else []
        blocks += [Text(line, "quiet", printed=True) for line in [*lines[:MOST_LINES], *more]]
    if not comparison.wanted:
        blocks.append(Text("No algorithm could be run on any of the problems.", printed=True))
    return Section("Remarks", blocks)


def _short(reason: str) -> str:
    line = reason.splitlines()[0] if reason else ""
    return line if len(line) <= LONGEST else f"{line[: LONGEST - 1]}…"


def _evidence(comparison: BenchmarkResult, judged: Sequence[Standings]) -> list[Section]:
    failed = Table(
        [Column("Algorithm", "name"), Column("Runs", "number"), Column("Reason", "wide"), Column("Problems", "wide")],
        [(name, Cell(str(n), order=n), reason, where) for name, reason, n, where in tables.failure_rows(comparison)],
    )
    refused = Table(
        [Column("Algorithm", "name"), Column("Problem", "wide"), Column("Reason", "wide")],
        tables.refusal_rows(comparison),
    )
    scopes = [("Limitations", scope) for scope in dict.fromkeys(one.scope for one in judged)]
    return [
        *(section for one in judged for section in _problems(comparison, one)),
        Section("Problems", [_problem_table(comparison, judged)]),
        Section("Runs that failed", [failed]),
        Section("What could not be run", [refused]),
        Section("How it was measured", [_terms(words.measured(comparison), "Condition", "Value")]),
        Section("How to read it", [_terms([*words.READING, *scopes], "Term", "Meaning")]),
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
            Cell(one.name, below=[one.title, *(["noisy"] if one.noisy else [])]),
            Cell(str(one.dimension), order=one.dimension),
            f"{one.budget:,}",
            words.target(one, tolerance[one.family]) if one.family in tolerance else "",
        )
        for one in comparison.problems
    ]
    return Table([Column("Problem", "name", 30), Column("Variables"), Column("Budget"), Column("Target", "wide")], rows)
