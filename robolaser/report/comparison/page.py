"""The report of a comparison, as a page and in twenty lines on the terminal."""

from collections.abc import Mapping, Sequence
from dataclasses import replace
from typing import Any

import numpy as np

from robolaser.arrays import Array
from robolaser.benchmark.measures import attainment
from robolaser.benchmark.problem import ProblemSummary
from robolaser.benchmark.result import BenchmarkResult
from robolaser.benchmark.standings.answer import names
from robolaser.benchmark.standings.table import Standings
from robolaser.benchmark.statistics.running_time import budgets, shares
from robolaser.report.chart import HEIGHT_PX, LINES, MUTED, Chart, chart, colours, hover, layer, line, quantity, records
from robolaser.report.comparison import tables, words
from robolaser.report.document import Column, Content, Document, Section, Table, TableCell, Text, charts

LONG = 140  # letters above which a sentence is too long for large type
MOST_PRINTED, FEWEST_PRINTED = 12, 4  # algorithms that the terminal shows of all families together, and of each
MOST_LINES = 8  # problems, failures and refusals that the terminal shows

LEADING = 6  # algorithms that have a colour of their own, by rank
NOISY = "noisy: runs are ranked by their returned candidates, re-evaluated"


def document(comparison: BenchmarkResult, judged: Sequence[Standings], *, brief: bool = False) -> Document:
    """The report, given the standings of each family of problems; in brief without the parts that only a page shows."""
    shown = judged if comparison.runs else ()
    nothing = "No run has finished yet." if comparison.wanted else "No algorithm could be run on any of the problems."
    lead, sense = _parted(shown[0].order.answer if shown else nothing)
    sections = [_family(comparison, one, i, brief=brief) for i, one in enumerate(shown)]
    sections += [] if brief else [section for one in shown for section in _problems(comparison, one)]
    sections += _conditions(comparison, shown)
    if not brief:
        scopes = [("Limitations", scope) for scope in dict.fromkeys(one.scope for one in shown)]
        terms = [Column("Condition", "name", 20), Column("Value", "wide")]
        sections.append(Section("How it was measured", [Table(terms, [*words.measured(comparison), *scopes])]))
    title = names([problem.name for problem in comparison.problems])
    return Document(title, "compared", words.setting(comparison), lead, sense, [], sections, prints_lead=True)


def _parted(answer: str) -> tuple[str, str]:
    """The first statement of an answer, and the rest."""
    lead, _, rest = answer.partition(". ")
    if len(lead) <= LONG or ": " not in lead:
        return f"{lead.rstrip('.')}.", rest
    lead, _, rest = answer.partition(": ")
    return f"{lead}:", rest


def _family(comparison: BenchmarkResult, standings: Standings, number: int, *, brief: bool) -> Section:
    title = words.FAMILIES[standings.family]
    most = max(FEWEST_PRINTED, MOST_PRINTED // len(comparison.families))
    table = tables.standing_table(comparison, standings, _numbers(standings), most)
    blocks: list[Content] = [] if number == 0 else [Text(standings.order.answer, printed=True)]
    blocks.append(replace(table, title=title) if brief and len(comparison.families) > 1 else table)
    blocks.append(tables.effect_table(standings))
    if not brief:
        blocks += charts([solved(comparison, standings, f"Targets reached by evaluations: {title.lower()}")])
        blocks += [tables.pairwise_matrix(standings.order)] if len(standings.by_problem) > 1 else []
    return Section(title, blocks)


def _numbers(standings: Standings) -> Mapping[str, int]:
    """Colour numbers of the leading algorithms."""
    return {place.algorithm: i for i, place in enumerate(standings.order.places[:LEADING])}


def solved(comparison: BenchmarkResult, standings: Standings, title: str) -> Chart | None:
    """Share of targets reached, over evaluations."""
    arrays = comparison.arrays(standings.family)
    spent = budgets(arrays.evaluations, arrays.total_evaluations)
    if len(spent) < 2 or spent[0] >= spent[-1]:
        return None
    reached = dict(zip(arrays.algorithms, 100 * shares(arrays.evaluations, spent), strict=True))
    drawn = {name: _steps(spent, share) for name, share in reached.items() if np.isfinite(share).all()}
    last = max(drawn, key=lambda name: reached[name][-1])
    easiest, hardest = (words.number(arrays.tolerances[end]) for end in (0, -1))
    return _step_chart(
        standings,
        title,
        f"Share of all {len(arrays.tolerances)} targets from {easiest} to {hardest} above the lowest known cost"
        " (relative to J), over all runs and problems, reached by then. Higher and further left is better."
        " A line that levels off low means that runs got stuck.",
        f"In the end {last} has reached {reached[last][-1]:.0f} % of the targets.",
        drawn,
        tooltip=hover("series", spent="evaluations", share="targets reached [%]"),
        x=quantity("spent", "evaluations", log=True, domain=(spent[0], spent[-1])),
        y=quantity("share", "targets reached, over all runs [%]", domain=(0, 100)),
    )


def attained(comparison: BenchmarkResult, standings: Standings, problem: ProblemSummary) -> Chart | None:
    """Median attainment surfaces of the leading algorithms, of two objectives."""
    if problem.objectives != 2:
        return None
    drawn = {}
    for name in _numbers(standings):
        surface = attainment([run for run in comparison.made if run.key[:2] == (problem.name, name)])
        if len(surface):
            first, second = surface[surface[:, 0].argsort()].T
            drawn[name] = {"first": first, "second": second}
    if not drawn:
        return None
    return _step_chart(
        standings,
        f"Half of the runs attain this on {problem.name}",
        "What half of the runs have attained or dominated in the end; nearer to the lower left corner is better"
        " (Grunert da Fonseca, Fonseca and Hall 2001).",
        f"The surfaces of {', '.join(drawn)}.",
        drawn,
        tooltip=hover("series", first="first objective", second="second objective"),
        x=quantity("first", "first objective"),
        y=quantity("second", "second objective"),
    )


def _step_chart(
    standings: Standings, title: str, caption: str, alt: str, drawn: Mapping[str, Mapping[str, Array]], **encoding: Any
) -> Chart:
    """A step line of each algorithm, the best drawn last; those that do not lead are grey."""
    order, coloured = [place.algorithm for place in standings.order.places], _numbers(standings)
    of = {name: LINES[coloured[name]] if name in coloured else MUTED for name in order if name in drawn}
    rows = [row for name in reversed(of) for row in records(**drawn[name], series=name)]
    colour = colours(of, legend={"orient": "bottom", "columns": 2})
    lines = layer(line(step=True), rows, color=colour, **encoding)
    return chart(title, caption, alt, [lines], height=HEIGHT_PX + 12 * min(len(order), LEADING))


def _steps(spent: Array, share: Array) -> dict[str, Array]:
    """The corners of a step line."""
    kept: Sequence[int] = np.unique([0, *(np.flatnonzero(np.diff(share)) + 1), len(spent) - 1]).tolist()
    return {"spent": spent[kept], "share": share[kept]}


def _conditions(comparison: BenchmarkResult, judged: Sequence[Standings]) -> list[Section]:
    """Problems with their targets, failures, and what could not be run."""
    failures = ((run.algorithm, run.reason, run.problem) for run in comparison.failures)
    refusals = ((name, reason, problem) for (problem, name), reason in comparison.refused.items())
    failed = Table(
        [Column("Algorithm", "name", brief="failed"), Column("Runs", "number", brief="runs"),
         Column("Reason", "wide", brief="reason"), Column("Problems", "wide")],
        [(name, TableCell(str(n), order=n), why, where) for name, why, n, where in tables.by_reason(failures)],
        printed=MOST_LINES,
    )  # fmt: skip
    refused = Table(
        [Column("Algorithm", "name", brief="not run"), Column("Problem", "wide", brief="on"),
         Column("Reason", "wide", brief="reason")],
        [(name, where, why) for name, why, _, where in tables.by_reason(refusals)],
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
        blocks: list[Content] = [Text(problem.title, "quiet")]
        blocks += [Text(on.order.answer)] if several else []
        blocks += charts([attained(comparison, standings, problem)])
        blocks.append(tables.result_table(problem, on, standings.tolerance, _numbers(standings)))
        blocks.append(tables.pairwise_matrix(on.order))
        sections.append(Section(problem.name, blocks))
    return sections


def _problem_table(comparison: BenchmarkResult, judged: Sequence[Standings]) -> Table:
    tolerance = {one.family: one.tolerance for one in judged}
    rows = [
        (
            TableCell(one.name, below=[one.title], note=NOISY if one.noisy else ""),
            TableCell(str(one.dimension), order=one.dimension),
            f"{one.budget:,}",
            words.target(one, tolerance[one.family]) if one.family in tolerance else "",
        )
        for one in comparison.problems
    ]
    columns = [Column("Problem", "name", 30, "problem"), Column("Variables"), Column("Budget")]
    return Table([*columns, Column("Target", "wide", brief="target")], rows, printed=MOST_LINES)
