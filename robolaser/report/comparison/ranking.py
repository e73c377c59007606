"""Tables of algorithms: their ranks in a family of problems, and their results on one problem."""

import math
from collections.abc import Sequence

import numpy as np

from robolaser.arrays import Array
from robolaser.benchmark.problem import ProblemSummary
from robolaser.benchmark.result_arrays import SHOWN
from robolaser.benchmark.standings.answer import chance
from robolaser.benchmark.standings.table import OnProblem, Pair, Reached, Result, Standing
from robolaser.benchmark.statistics.intervals import IntervalEstimate
from robolaser.report.comparison.excess import number
from robolaser.report.comparison.plot_context import PlotContext
from robolaser.report.digits import NEVER, count, duration, interval, manifold, many, rate
from robolaser.report.document import Cell, Column, Table

FEW, SHORT = 3, 12
"""Problems that have a line each in one cell, and letters of a name there."""


def standing_table(context: PlotContext, most: int) -> Table:
    """All algorithms of a family, the best first; `most` of them on the terminal."""
    by_seconds = {standing.algorithm: standing for standing in context.standings.seconds.places}
    ends = "RMS above the best known, at the end" if context.calibrates else "Cost above the lowest, at the end"
    columns = [
        Column("Algorithm", "name", 25, "algorithm"),
        Column("Rank", brief="rank"),
        Column("Success", brief="success"),
        Column("Evaluations to the target", brief="evaluations"),
        Column("Time to the target", brief="time"),
        Column("Significantly worse than the first?", brief="worse than the first?"),
        Column(ends),
        Column("Failed", brief="failed"),
    ]
    rows = [
        _standing(context, standing, by_seconds[standing.algorithm])
        for standing in context.standings.evaluations.places
    ]
    told = [i for i in range(len(columns)) if i < len(columns) - 2 or any(row[i].text or row[i].below for row in rows)]
    columns, rows = [columns[i] for i in told], [[row[i] for i in told] for row in rows]
    note = (
        f"Target: {context.target(context.standings.tolerance)}. Evaluations and time are what it takes on average to"
        " get there (ERT), × times as much as the first in that measure, with its 95 % interval."
    )
    return Table(columns, rows, note=note, printed=most)


def _standing(context: PlotContext, standing: Standing, in_seconds: Standing) -> list[Cell]:
    name = standing.algorithm
    results = [result for on in context.standings.by_problem for result in on.results if result.algorithm == name]
    at = [(result.problem, one) for result in results if (one := reached(result, context.standings.tolerance))]
    problems = len(context.problems)
    solved = f"{standing.solved} of {problems} problems" if standing.solved < problems > 1 and standing.runs else ""
    success = standing.success.value
    between = _interval(standing.success)
    return [
        Cell(name, below=_lines(context.comparison.solvers[name]), note=standing.unranked,
             line=line_number(context, name)),
        Cell(_rank(standing), order=standing.rank or np.inf),
        Cell("" if success is None else f"{rate(success)}" + (f" ({between})" if between else ""),
             below=_lines(solved), order=success),
        _price(standing, [(_numbered(context, problem), count(_known(one.evaluations))) for problem, one in at]),
        _price(
            in_seconds,
            [(_numbered(context, problem), duration(_known(one.seconds))) for problem, one in at],
            f"rank {_rank(in_seconds)} by time" if in_seconds.rank not in (standing.rank, None) else "",
        ),
        _against(standing),
        _final(context, [result for result in results if result.final is not None]),
        Cell(f"{standing.failed} of {standing.runs}" if standing.failed else ""),
    ]  # fmt: skip


def _numbered(context: PlotContext, problem: str) -> str:
    """A problem's name, or its number where the name would fill the line."""
    return problem if len(problem) <= SHORT else f"problem {context.number(problem)}:"


def result_table(context: PlotContext, on: OnProblem) -> Table:
    """All algorithms on a problem, the best first: time and success at each of the shown targets, final results."""
    of = {result.algorithm: result for result in on.results}
    problem = context.contested(on.problem)
    rows = [
        (
            Cell(standing.algorithm, line=line_number(context, standing.algorithm)),
            Cell(_rank(standing), order=standing.rank or np.inf),
            *(_target(reached(of[standing.algorithm], tolerance), standing.runs) for tolerance in SHOWN),
            _quality(context, problem, of[standing.algorithm]),
            *_front(context.igd_plus.get((problem.name, standing.algorithm))),
        )
        for standing in on.evaluations.places
    ]
    columns = [Column("Algorithm", "name", 23), Column("Rank")]
    columns += [Column(context.target(tolerance)) for tolerance in SHOWN]
    columns += [Column("Final result above the best known: median, quartiles")]
    columns += [Column("IGD+ of the fronts: median, quartiles")] * (len(rows[0]) - len(columns) if rows else 0)
    return Table(columns, rows, "Fixed targets: expected evaluations to each, and final results")


def _front(quartiles: Array | None) -> list[Cell]:
    """How far fronts fall short of the best known one, in units of its extent."""
    if quartiles is None:
        return []
    lower, median, upper = (number(one) if np.isfinite(one) else "no front" for one in quartiles)
    return [Cell(median, (f"{lower} to {upper}",), order=float(quartiles[1]))]


def reached(result: Result, tolerance: float) -> Reached | None:
    """What is known of a target."""
    return min(result.targets, key=lambda one: abs(one.tolerance / tolerance - 1.0), default=None)


def line_number(context: PlotContext, name: str) -> int:
    """The number of an algorithm's colour; -1 without one."""
    coloured = list(context.coloured)
    return coloured.index(name) if name in coloured else -1


def _known(estimate: IntervalEstimate) -> float:
    return float("inf") if estimate.value is None else estimate.value


def _rank(standing: Standing) -> str:
    return "–" if standing.rank is None else str(standing.rank)


def _interval(estimate: IntervalEstimate) -> str:
    if estimate.lower is None or estimate.upper is None:
        return ""
    return interval(estimate.lower, estimate.upper)


def _lines(*lines: str) -> tuple[str, ...]:
    return tuple(line for line in lines if line)


def _price(standing: Standing, each: Sequence[tuple[str, str]], remark: str = "") -> Cell:
    """The price itself on one problem, times the first's over several."""
    if not standing.runs:
        return Cell("")
    if not standing.solved:
        return Cell(NEVER, _lines(remark))
    ratio, between = ("the first", "") if standing.rank == 1 else _ratio(standing.against_first)
    if len(each) == 1:
        return Cell(each[0][1], _lines(f"{ratio} ({between})" if between else ratio, remark))
    prices_of = [f"{problem} {price}" for problem, price in each] if len(each) <= FEW else []
    return Cell(ratio or "–", _lines(between, *prices_of, remark))


def _ratio(pair: Pair | None) -> tuple[str, str]:
    """How many times the first's, and between which two."""
    if pair is None or pair.ratio.value is None:
        return "", ""
    shown, lower, upper = many(pair.ratio.value), pair.ratio.lower, pair.ratio.upper
    if lower is None:
        return shown, ""
    if upper is None:
        return shown, f"at least {manifold(lower)}"
    return shown, f"{manifold(lower)} to {manifold(upper)}"


def _against(standing: Standing) -> Cell:
    pair = standing.against_first
    if pair is None or pair.p_adjusted is None or pair.superiority.value is None:
        return Cell("")
    return Cell(
        f"{'yes' if pair.significant else 'no'}, {chance(pair.p_adjusted)}",
        (f"loses {rate(pair.superiority.value)} of pairs",),
        order=pair.p_adjusted,
    )


def _target(one: Reached | None, runs: int) -> Cell:
    if one is None or not runs:
        return Cell("")
    success = f"{one.successes} of {runs} runs"
    if not one.successes:
        return Cell(NEVER, (success,))
    spent = _known(one.evaluations)
    return Cell(count(spent), (duration(_known(one.seconds)), success), order=spent)


def _quality(context: PlotContext, problem: ProblemSummary, result: Result) -> Cell:
    """Median, and quartiles unless they are alike; the violation where most runs found nothing feasible."""
    quality = result.final
    if quality is None:
        return Cell("")
    if quality["median"] is None and result.violation is not None:
        return Cell("nothing feasible", (f"violation {number(result.violation)}",))
    return quartile_cell(
        context,
        problem,
        *(math.inf if (one := quality[end]) is None else one for end in ("lower_quartile", "median", "upper_quartile")),
    )


def quartile_cell(context: PlotContext, problem: ProblemSummary, *quartiles: float) -> Cell:
    """Median of costs above the best known, and lower and upper quartile unless all are alike."""
    lower, median, upper = (context.excess(problem, one) for one in quartiles)
    return Cell(median, () if median == lower == upper else (f"{lower} to {upper}",), order=quartiles[1])


def _final(context: PlotContext, results: Sequence[Result]) -> Cell:
    if len(context.problems) == 1 and results:
        return _quality(context, context.problems[0], results[0])
    if len(context.problems) > FEW:
        return Cell("")
    return Cell(
        "",
        [
            f"{_numbered(context, one.problem)} {_quality(context, context.contested(one.problem), one).text}"
            for one in results
        ],
    )
