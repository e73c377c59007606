"""The tables of a comparison: ranks, results on a problem, pairs, exchanged parts, and what could not be run."""

import math
from collections.abc import Mapping, Sequence

import numpy as np

from robolaser.benchmark.measures import ProblemSummary
from robolaser.benchmark.result import BenchmarkResult
from robolaser.benchmark.standings import Standings
from robolaser.benchmark.standings.answer import between, chance, figure, share
from robolaser.benchmark.standings.table import OnProblem, Order, Pair, Result, Standing
from robolaser.report.comparison.words import excess, number, spans, target
from robolaser.report.digits import NEVER, count, duration, many, rate
from robolaser.report.document import Cell, Column, Table

FEW = 8
"""Algorithms up to which a matrix of pairs is shown unfolded."""
MANY = 8
"""Problems up to which each has a line in one cell."""


def standing_table(comparison: BenchmarkResult, standings: Standings, colours: Mapping[str, int], most: int) -> Table:
    """All algorithms of a family, the best first; `most` of them on the terminal."""
    columns = [
        Column("Algorithm", "name", 25, "algorithm"),
        Column("Rank", brief="rank"),
        Column("Success", brief="success"),
        Column("Evaluations to the target (ERT)", brief="evaluations"),
        Column("Time to the target", brief="time"),
        Column("Significantly worse than the first?", brief="worse than the first?"),
        Column("Failed", brief="failed"),
    ]
    rows = [_standing(comparison, standings, one, colours) for one in standings.order.places]
    told = [i for i in range(len(columns)) if i < len(columns) - 1 or any(row[i].text for row in rows)]
    note = (
        "Evaluations and time are what it takes on average to get to the target; over several problems, × times as many"
        " as the first where both reached it, with the 95 % interval."
    )
    return Table([columns[i] for i in told], [[row[i] for i in told] for row in rows], note=note, printed=most)


def _standing(
    comparison: BenchmarkResult, standings: Standings, standing: Standing, colours: Mapping[str, int]
) -> list[Cell]:
    name = standing.algorithm
    results = [result for on in standings.by_problem for result in on.results if result.algorithm == name]
    problems = len(standings.by_problem)
    solved = [f"{standing.solved} of {problems} problems"] if standing.solved < problems > 1 and standing.runs else []
    about = [comparison.solvers[name], *(["knows its budget"] if name in comparison.know_budget else [])]
    success = standing.success
    seconds = [] if len(results) > MANY else [duration(one.seconds) for one in results if one.seconds is not None]
    return [
        Cell(name, below=about, note=standing.unranked, line=colours.get(name, -1)),
        Cell("–" if standing.rank is None else str(standing.rank), order=standing.rank or np.inf),
        Cell("" if success.value is None else share(success), below=solved, order=success.value),
        _price(standing, results),
        Cell("; ".join(seconds) if standing.solved else ""),
        _against(standing),
        Cell(f"{standing.failed} of {standing.runs}" if standing.failed else ""),
    ]


def _price(standing: Standing, results: Sequence[Result]) -> Cell:
    """The price itself on one problem, times the first's over several; nobody is compared with who never got there."""
    if not standing.runs:
        return Cell("")
    if not standing.solved:
        return Cell(NEVER)
    ratio = "" if standing.against_first is None else _ratio(standing.against_first)
    if len(results) == 1 and (spent := results[0].evaluations).value is not None:
        return Cell(
            f"{count(spent.value)}{between(spent) if spent.lower else ''}", [ratio] if ratio else [], order=spent.value
        )
    prices = [f"{one.problem} {count(one.evaluations.value)}" for one in results if one.evaluations.value is not None]
    shown = ratio or ("the first" if standing.rank == 1 else "–")
    return Cell(shown, prices if len(prices) <= MANY else [])


def _ratio(pair: Pair) -> str:
    return "" if pair.ratio.value is None else f"{many(pair.ratio.value)}{between(pair.ratio)}"


def _against(standing: Standing) -> Cell:
    pair = standing.against_first
    if pair is None or pair.p_adjusted is None or pair.superiority.value is None:
        return Cell("")
    return Cell(
        f"{'yes' if pair.significant else 'no'}, {chance(pair.p_adjusted)}",
        (f"loses {rate(pair.superiority.value)} of pairs",),
        order=pair.p_adjusted,
    )


def result_table(problem: ProblemSummary, on: OnProblem, tolerance: float, colours: Mapping[str, int]) -> Table:
    """All algorithms on a problem, the best first: time and success at some targets, and final results."""
    of = {result.algorithm: result for result in on.results}
    every = [one.tolerance for one in on.results[0].targets] if on.results else []
    wanted = sorted(
        {min(every, key=lambda t: abs(math.log(t / one))) for one in (1.0, tolerance, every[-1])}, reverse=True
    )
    rows = [
        [
            Cell(place.algorithm, line=colours.get(place.algorithm, -1)),
            Cell("–" if place.rank is None else str(place.rank), order=place.rank or np.inf),
            *(_reached(of[place.algorithm], one) for one in wanted),
            _quality(problem, of[place.algorithm]),
        ]
        for place in on.order.places
    ]
    columns = [Column("Algorithm", "name", 23), Column("Rank"), *(Column(f"ERT to {number(one)}") for one in wanted)]
    columns.append(Column("Final result above the best known: median, quartiles"))
    return Table(
        columns,
        rows,
        "Expected evaluations to three targets, and final results",
        note=f"Ranked by the target: {target(problem, tolerance)}.",
    )


def _reached(result: Result, tolerance: float) -> Cell:
    one = next(one for one in result.targets if one.tolerance == tolerance)
    if not result.runs:
        return Cell("")
    success = f"{one.successes} of {result.runs} runs"
    return (
        Cell(NEVER, (success,))
        if one.evaluations is None
        else Cell(count(one.evaluations), (success,), order=one.evaluations)
    )


def _quality(problem: ProblemSummary, result: Result) -> Cell:
    """Median, and quartiles unless they are alike; the violation where most runs found nothing feasible."""
    if result.final is None:
        return Cell("")
    if result.final["median"] is None and result.violation is not None:
        return Cell("nothing feasible", (f"violation {number(result.violation)}",))
    ends = [result.final[end] for end in ("lower_quartile", "median", "upper_quartile")]
    lower, median, upper = (excess(problem, math.inf if end is None else end) for end in ends)
    return Cell(median, () if lower == upper else (f"{lower} to {upper}",), order=ends[1])


def pairwise_matrix(order: Order) -> Table:
    """Algorithms in order, each against each."""
    names = [standing.algorithm for standing in order.places]
    of = {(pair.one, pair.other): pair for pair in order.pairs}
    rows = [[Cell(f"{i} {one}"), *(_pair(of, one, other) for other in names)] for i, one in enumerate(names, 1)]
    note = (
        "A12: how often a run of the row's algorithm does better than one of the column's. With a star: significant"
        " after Holm's correction. Blue: the row's is better; orange: the column's."
    )
    columns = [Column("Row beats column"), *(Column(str(i)) for i in range(1, len(names) + 1))]
    return Table(columns, rows if len(names) > 1 else [], "Pairwise comparison", note, FEW, kind="matrix")


def _pair(of: Mapping[tuple[str, str], Pair], one: str, other: str) -> Cell:
    if one == other:
        return Cell("·")
    pair = of.get((one, other)) or of.get((other, one))
    if pair is None or pair.superiority.value is None:
        return Cell(hint="nothing is known of these two")
    value = pair.superiority.value if pair.one == one else 1.0 - pair.superiority.value
    p = "" if pair.p_adjusted is None else f", {chance(pair.p_adjusted)}"
    significant = "significant" if pair.significant else "not significant"
    return Cell(
        f"{value:.2f}{'*' if pair.significant else ''}",
        order=value,
        lean=200 * (value - 0.5),
        hint=f"{one} beats {other} in {100 * value:.0f} % of pairs; {significant}{p}",
    )


def effect_table(standings: Standings) -> Table | None:
    """A row for each exchanged part; None where no part is exchanged."""
    columns = [
        Column("Part", "name", 30, "part"),
        Column("In place of", "text"),
        Column("Better in so many pairs of runs", brief="better in"),
        Column("Times as many evaluations", brief="times the evaluations"),
        Column("p", brief="p"),
    ]
    rows = [
        (
            Cell(f"{effect.operator} as {effect.slot}"),
            f"{effect.stock}'s own",
            Cell(share(effect.superiority), order=effect.superiority.value),
            Cell(
                "–" if effect.ratio.value is None else f"{figure(effect.ratio.value)}{between(effect.ratio)}",
                order=effect.ratio.value,
            ),
            Cell(chance(effect.p_adjusted), order=effect.p_adjusted),
        )
        for effect in standings.effects
    ]
    note = (
        "Runs with the part against runs without it that are alike in all else (problem, other parts), with 95 %"
        " intervals: 50 % of pairs is no effect; below 1 it reaches the target faster. p: van Elteren's test, by Holm"
        " for all parts."
    )
    return Table(columns, rows, "What each exchanged part does", note, printed=len(rows)) if rows else None


def failure_rows(comparison: BenchmarkResult) -> list[tuple[str, str, int, str]]:
    """Algorithm, reason, runs, and on which problems with which seeds, those with one reason together."""
    grouped: dict[tuple[str, str], dict[str, list[int]]] = {}
    for run in comparison.failures:
        grouped.setdefault((run.algorithm, run.reason), {}).setdefault(run.problem, []).append(run.seed)
    return [
        (name, reason, sum(map(len, where.values())), "; ".join(f"{p}: seed {spans(of)}" for p, of in where.items()))
        for (name, reason), where in grouped.items()
    ]


def refusal_rows(comparison: BenchmarkResult) -> list[tuple[str, str, str]]:
    """Algorithm, problems it was not run on, and why."""
    grouped: dict[tuple[str, str], list[str]] = {}
    for (problem, name), reason in comparison.refused.items():
        grouped.setdefault((name, reason), []).append(problem)
    return [(name, ", ".join(problems), reason) for (name, reason), problems in grouped.items()]
