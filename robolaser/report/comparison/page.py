"""The page of a comparison: one file that needs nothing else."""

import re
from collections.abc import Sequence
from dataclasses import dataclass
from typing import final

import numpy as np

from robolaser.benchmark.result import BenchmarkResult
from robolaser.benchmark.result_arrays import SHOWN
from robolaser.benchmark.standings import Standings
from robolaser.report.chart import Chart
from robolaser.report.comparison import methods, rows
from robolaser.report.comparison.charts.anytime import anytime
from robolaser.report.comparison.charts.ranks import mean_ranks
from robolaser.report.comparison.charts.solved import TITLES, solved
from robolaser.report.comparison.charts.targets import targets
from robolaser.report.comparison.pairwise import PairwiseCell, pairwise_matrix
from robolaser.report.comparison.plot_context import PlotContext, target
from robolaser.report.comparison.ranking import ResultRow, StandingRow, result_rows, standing_rows
from robolaser.report.digits import plain
from robolaser.report.page import drawn, render

FEW = 8
"""Algorithms up to which a matrix of pairs is shown unfolded."""
LONG = 140
"""Letters of a sentence that is too long for large type."""
NOTHING = "No run has finished yet."


@final
@dataclass(frozen=True, eq=False)
class FamilyPart:
    """A family of problems on the page."""

    title: str
    target: str
    answers: Sequence[str]
    table: Sequence[StandingRow]
    charts: Sequence[Chart]
    names: Sequence[str]
    pairs: Sequence[Sequence[PairwiseCell | None]]
    scope: str
    ends: str


@final
@dataclass(frozen=True, eq=False)
class ProblemPart:
    """A problem on the page."""

    title: str
    meaning: str
    answer: str
    targets: Sequence[str]
    table: Sequence[ResultRow]
    charts: Sequence[Chart]
    names: Sequence[str]
    pairs: Sequence[Sequence[PairwiseCell | None]]


@final
@dataclass(frozen=True)
class ProblemRow:
    """A problem in the table of problems."""

    number: int
    name: str
    title: str
    dimension: int
    best: str
    found_by: str
    targets: str


def page(comparison: BenchmarkResult, judged: Sequence[Standings], *, command: str = "") -> str:
    """The page as HTML.

    Args:
        comparison: What was run.
        judged: The standings of each family of problems.
        command: What to type to repeat it.
    """
    contexts = [PlotContext(comparison, standings) for standings in (judged if comparison.runs else ())]
    families = [_family(context, 1 + i) for i, context in enumerate(contexts)]
    lead, sense = _parted(unbroken(verdict(comparison, judged)))
    return render(
        "comparison.html",
        comparison=comparison,
        name=", ".join(problem.name for problem in comparison.problems),
        setting=methods.setting(comparison),
        lead=lead,
        sense=sense,
        missing=methods.missing(comparison),
        families=families,
        parts=[part for context in contexts for part in _problems(context)],
        problems=_problem_rows(comparison),
        failures=list(rows.failure_rows(comparison)),
        refusals=list(rows.refusal_rows(comparison)),
        measured=methods.measured(comparison),
        reading=methods.READING,
        few=FEW,
        command=command,
    )


def verdict(comparison: BenchmarkResult, judged: Sequence[Standings]) -> str:
    """Which is better, by how much and how certain, in the first family of problems."""
    if not comparison.runs or not judged:
        return NOTHING
    return judged[0].evaluations.answer or NOTHING


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


def _family(context: PlotContext, number: int) -> FamilyPart:

    standings = context.standings
    title = methods.FAMILIES.get(standings.family, standings.family)
    suffix = f" ({title.lower()})" if len(context.comparison.families) > 1 else ""
    made = [
        solved(context, "evaluations", TITLES["evaluations"] + suffix),
        solved(context, "seconds", TITLES["seconds"] + suffix),
        mean_ranks(context, standings.evaluations.ranks, f"Mean ranks by evaluations{suffix}"),
        mean_ranks(context, standings.seconds.ranks, f"Mean ranks by wall time{suffix}"),
    ]
    names, matrix = pairwise_matrix(standings.evaluations) if len(context.problems) > 1 else ((), ())
    above = verdict(context.comparison, (standings,)) if number == 1 else ""
    answers = dict.fromkeys((standings.evaluations.answer, standings.seconds.answer))
    return FamilyPart(
        title,
        context.target(standings.tolerance),
        [unbroken(answer) for answer in answers if answer != above],
        standing_rows(context),
        drawn(made),
        names,
        matrix,
        standings.scope,
        "RMS above the best known, at the end" if context.calibrates else "Cost above the lowest, at the end",
    )


def _problems(context: PlotContext) -> Sequence[ProblemPart]:

    parts = []
    for on in context.standings.by_problem:
        problem = context.contested(on.problem)
        number = context.number(problem.name)
        made = [
            anytime(context, problem, f"Best so far on {problem.name} (problem {number})"),
            targets(context, problem, on, f"Evaluations needed per target on {problem.name} (problem {number})"),
        ]
        names, matrix = pairwise_matrix(on.evaluations)
        parts.append(
            ProblemPart(
                f"{number}. {problem.name}",
                problem.title,
                unbroken(on.evaluations.answer) if len(context.problems) > 1 else "",
                [context.target(tolerance) for tolerance in SHOWN],
                result_rows(context, on),
                drawn(made),
                names,
                matrix,
            )
        )
    return parts


def _problem_rows(comparison: BenchmarkResult) -> list[ProblemRow]:
    return [
        ProblemRow(
            1 + i,
            problem.name,
            problem.title,
            problem.dimension,
            plain(problem.best, problem.unit) if np.isfinite(problem.best) else "not known",
            methods.found_by(problem.found_by),
            "; ".join(target(problem.family, tolerance) for tolerance in SHOWN),
        )
        for i, problem in enumerate(comparison.problems)
    ]
