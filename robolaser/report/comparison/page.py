"""The report of a comparison."""

import re
from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from robolaser.benchmark.result import BenchmarkResult
from robolaser.benchmark.result_arrays import SHOWN
from robolaser.benchmark.standings import Standings
from robolaser.benchmark.standings.answer import names
from robolaser.report.comparison import methods, rows
from robolaser.report.comparison.budgets import budget_table
from robolaser.report.comparison.charts.anytime import anytime
from robolaser.report.comparison.charts.attained import attained
from robolaser.report.comparison.charts.profiles import profiles
from robolaser.report.comparison.charts.ranks import mean_ranks
from robolaser.report.comparison.charts.solved import TITLES, solved
from robolaser.report.comparison.charts.targets import targets
from robolaser.report.comparison.exchanged import effect_table
from robolaser.report.comparison.grouped import all_results, group_table
from robolaser.report.comparison.pairwise import pairwise_matrix
from robolaser.report.comparison.plot_context import PlotContext, target
from robolaser.report.comparison.probable import probable_table
from robolaser.report.comparison.ranking import result_table, standing_table
from robolaser.report.digits import plain
from robolaser.report.document import Block, Cell, Column, Document, Section, Table, Text, charts
from robolaser.report.page import render

LONG = 140
"""Letters of a sentence that is too long for large type."""
MOST_PRINTED, FEWEST_PRINTED = 12, 4
"""Algorithms that the terminal shows of all families together, and of each."""
MOST_DRAWN = 30
"""Problems with a section each; of more there are tables."""
NOTHING = "No run has finished yet."


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
    contexts = [PlotContext(comparison, standings) for standings in (judged if comparison.runs else ())]
    lead, sense = _parted(unbroken(verdict(comparison, judged)))
    families = [_family(context, i, brief=brief) for i, context in enumerate(contexts)]
    return Document(
        names([problem.name for problem in comparison.problems]),
        "compared",
        methods.setting(comparison),
        lead,
        sense,
        [],
        families if brief else [*families, *_evidence(comparison, contexts)],
        tag=(methods.missing(comparison), "unexplained"),
        command=command,
        prints_lead=True,
    )


def page(comparison: BenchmarkResult, judged: Sequence[Standings], *, command: str = "") -> str:
    """The page as HTML.

    Args:
        comparison: What was run.
        judged: The standings of each family of problems.
        command: What to type to repeat it.
    """
    return render(document(comparison, judged, command=command))


def verdict(comparison: BenchmarkResult, judged: Sequence[Standings]) -> str:
    """Which is better, by how much and how certain, in the first family of problems."""
    if not comparison.runs or not judged:
        return NOTHING
    return f"{_raced(comparison)}{judged[0].evaluations.answer}" or NOTHING


def _raced(comparison: BenchmarkResult) -> str:
    """Whom a race left."""
    left = [name for name in comparison.solvers if name not in comparison.dropped]
    if not comparison.dropped:
        return ""
    return f"The race left {names(left)} of {len(comparison.solvers)} algorithms. "


def unbroken(text: str) -> str:
    """Numbers and what follows them on one line."""
    return re.sub(r"(?<=\d) (?=[%×])|(?<=p [<=]) | (?=[<=] \d)", "\u00a0", text)


def _parted(answer: str) -> tuple[str, str]:
    """The first thing that an answer says, and the rest."""
    lead, _, rest = answer.partition(". ")
    if len(lead) <= LONG or ": " not in lead:
        return f"{lead.rstrip('.')}.", rest
    lead, _, rest = answer.partition(": ")
    return f"{lead}:", rest


def _family(context: PlotContext, number: int, *, brief: bool) -> Section:
    standings, comparison = context.standings, context.comparison
    title = methods.FAMILIES.get(standings.family, standings.family)
    above = standings.evaluations.answer if number == 0 else ""
    most = max(FEWEST_PRINTED, MOST_PRINTED // len(comparison.families))
    spoken = (standings.evaluations.answer,) if brief else (standings.evaluations.answer, standings.seconds.answer)
    answers = [answer for answer in dict.fromkeys(spoken) if answer and answer != above]
    blocks: list[Block] = [Text(unbroken(answer), printed=True) for answer in answers]
    table = standing_table(context, most)
    blocks.append(replace(table, title=title) if brief and len(comparison.families) > 1 else table)
    if (exchanged := effect_table(standings)) is not None:
        blocks.append(exchanged)
    return Section(title, blocks if brief else [*blocks, *_family_evidence(context, title)])


def _family_evidence(context: PlotContext, title: str) -> list[Block]:
    standings = context.standings
    suffix = f" ({title.lower()})" if len(context.comparison.families) > 1 else ""
    made = [
        solved(context, "evaluations", TITLES["evaluations"] + suffix),
        solved(context, "seconds", TITLES["seconds"] + suffix),
        mean_ranks(context, standings.evaluations, f"Mean ranks by evaluations{suffix}"),
        mean_ranks(context, standings.seconds, f"Mean ranks by wall time{suffix}"),
        profiles(context, f"Evaluations against the fastest{suffix}"),
        solved(context, "simplex gradients", TITLES["simplex gradients"] + suffix)
        if len(context.problems) > 1
        else None,
    ]
    tables = [pairwise_matrix(standings.evaluations) if len(context.problems) > 1 else None, probable_table(context)]
    return [*charts(made), *(table for table in tables if table is not None)]


def _evidence(comparison: BenchmarkResult, contexts: Sequence[PlotContext]) -> list[Section]:
    scopes = dict.fromkeys(context.standings.scope for context in contexts if context.standings.scope)
    reading = [*methods.READING, *(("Limitations", scope) for scope in scopes)]
    sections = [
        *(section for context in contexts for section in _problems(context)),
        Section("Problems", [_problem_table(comparison)]),
        Section(
            "Algorithms", [] if contexts else [_terms(list(comparison.solvers.items()), "Algorithm", "What it is")]
        ),
        Section("Runs that failed", [rows.failure_table(comparison)] if comparison.failures else []),
        Section("What could not be run", [rows.refusal_table(comparison)] if comparison.refused else []),
        Section("How it was measured", [_terms(methods.measured(comparison), "Condition", "As it was")]),
        Section("How to read it", [_terms(reading, "Term", "What it means")]),
    ]
    return [section for section in sections if section.blocks]


def _problems(context: PlotContext) -> list[Section]:
    if len(context.problems) > MOST_DRAWN:
        return [Section(f"{len(context.problems)} problems", [group_table(context), all_results(context)])]
    sections = []
    for on in context.standings.by_problem:
        problem = context.contested(on.problem)
        number = context.number(problem.name)
        made = [
            anytime(context, problem, f"Best so far on {problem.name} (problem {number})"),
            attained(context, problem, f"Half of the runs attain this on {problem.name} (problem {number})"),
            targets(context, problem, on, f"Evaluations needed per target on {problem.name} (problem {number})"),
        ]
        blocks: list[Block] = [Text(problem.title, "quiet")]
        if len(context.problems) > 1 and on.evaluations.answer:
            blocks.append(Text(unbroken(on.evaluations.answer)))
        blocks += [
            *charts(made),
            result_table(context, on),
            budget_table(context, problem),
            pairwise_matrix(on.evaluations),
        ]
        sections.append(Section(f"{number}. {problem.name}", blocks))
    return sections


def _terms(items: Sequence[tuple[str, str]], *titles: str) -> Table:
    return Table([Column(titles[0], "name", 20), Column(titles[1], "wide")], items)


def _problem_table(comparison: BenchmarkResult) -> Table:
    columns = [Column("Problem", "name", 30), Column("Variables"), Column("Lowest cost known"), Column("Found by"),
               Column("Targets shown", "wide")]  # fmt: skip
    shown = [
        (
            Cell(f"{number}. {problem.name}", below=[problem.title] if problem.title else []),
            Cell(str(problem.dimension), order=problem.dimension),
            plain(problem.best, problem.unit) if np.isfinite(problem.best) else "not known",
            methods.found_by(problem.found_by),
            "; ".join(target(problem.family, tolerance) for tolerance in SHOWN),
        )
        for number, problem in enumerate(comparison.problems, 1)
    ]
    return Table(columns, shown)
