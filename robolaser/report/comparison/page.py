"""The page a person looks at after a comparison: one file that needs nothing else."""

import re
from collections.abc import Sequence
from dataclasses import dataclass
from typing import final

import numpy as np

from robolaser.benchmark.result import BenchmarkResult
from robolaser.benchmark.result_arrays import SHOWN
from robolaser.benchmark.standings import Standings
from robolaser.report import words
from robolaser.report.canvas import Picture
from robolaser.report.comparison import account, rows
from robolaser.report.comparison.duels import Duel, duels
from robolaser.report.comparison.field import Field, target
from robolaser.report.comparison.ranking import ResultRow, StandingRow, result_rows, standing_rows
from robolaser.report.digits import plain
from robolaser.report.page import render

FEW = 8
"""Solvers up to which a matrix of pairs is shown without being asked for."""
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
    pictures: Sequence[Picture]
    names: Sequence[str]
    pairs: Sequence[Sequence[Duel | None]]
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
    pictures: Sequence[Picture]
    names: Sequence[str]
    pairs: Sequence[Sequence[Duel | None]]


@final
@dataclass(frozen=True)
class ProblemRow:
    """What was asked."""

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
        judged: How solvers stand, for each family of problems.
        command: What to type to repeat it.
    """
    fields = [Field(comparison, standings) for standings in (judged if comparison.runs else ())]
    families = [_family(field, 1 + i) for i, field in enumerate(fields)]
    lead, sense = _parted(unbroken(verdict(comparison, judged)))
    return render(
        "comparison.html",
        comparison=comparison,
        name=", ".join(problem.name for problem in comparison.problems),
        setting=account.setting(comparison),
        lead=lead,
        sense=sense,
        missing=account.missing(comparison),
        families=families,
        parts=[part for field in fields for part in _problems(field)],
        problems=_problem_rows(comparison),
        failures=list(rows.failure_rows(comparison)),
        refusals=list(rows.refusal_rows(comparison)),
        measured=account.measured(comparison),
        reading=account.READING,
        few=FEW,
        command=command,
        version=words.version(),
    )


def verdict(comparison: BenchmarkResult, judged: Sequence[Standings]) -> str:
    """Which is better, by how much and how sure is that, in the first family of problems."""
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


def _family(field: Field, number: int) -> FamilyPart:
    from robolaser.report.comparison.pictures.differences import differences  # noqa: PLC0415 - Matplotlib is slow
    from robolaser.report.comparison.pictures.solved import TITLES, solved  # noqa: PLC0415

    standings = field.standings
    title = account.FAMILIES.get(standings.family, standings.family)
    suffix = f" ({title.lower()})" if len(field.comparison.families) > 1 else ""
    drawn = (
        solved(field, "evaluations", TITLES["evaluations"] + suffix),
        solved(field, "seconds", TITLES["seconds"] + suffix),
        differences(field, standings.evaluations.ranks, f"Told apart by evaluations{suffix}"),
        differences(field, standings.seconds.ranks, f"Told apart by wall time{suffix}"),
    )
    names, matrix = duels(standings.evaluations) if len(field.problems) > 1 else ((), ())
    above = verdict(field.comparison, (standings,)) if number == 1 else ""
    answers = dict.fromkeys((standings.evaluations.answer, standings.seconds.answer))
    return FamilyPart(
        title,
        field.target(standings.tolerance),
        [unbroken(answer) for answer in answers if answer != above],
        standing_rows(field),
        [picture for picture in drawn if picture is not None],
        names,
        matrix,
        standings.scope,
        "RMS above the best known, in the end" if field.calibrates else "Cost above the lowest, in the end",
    )


def _problems(field: Field) -> Sequence[ProblemPart]:
    from robolaser.report.comparison.pictures.anytime import anytime  # noqa: PLC0415
    from robolaser.report.comparison.pictures.targets import targets  # noqa: PLC0415

    parts = []
    for on in field.standings.by_problem:
        problem = field.problem_named(on.problem)
        number = field.number(problem.name)
        drawn = (
            anytime(field, problem, f"Best so far on {problem.name} (problem {number})"),
            targets(field, problem, on, f"Price of coming closer on {problem.name} (problem {number})"),
        )
        names, matrix = duels(on.evaluations)
        parts.append(
            ProblemPart(
                f"{number}. {problem.name}",
                problem.title,
                unbroken(on.evaluations.answer) if len(field.problems) > 1 else "",
                [field.target(tolerance) for tolerance in SHOWN],
                result_rows(field, on),
                [picture for picture in drawn if picture is not None],
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
            account.found_by(problem.found_by),
            "; ".join(target(problem.family, tolerance) for tolerance in SHOWN),
        )
        for i, problem in enumerate(comparison.problems)
    ]
