"""Tables of algorithms: their ranks in a family of problems, and their results on one problem."""

from collections.abc import Sequence
from dataclasses import dataclass
from typing import final

from robolaser.benchmark.problem import ProblemSummary
from robolaser.benchmark.result_arrays import SHOWN
from robolaser.benchmark.standings import IntervalEstimate, OnProblem, Pair, Reached, Result, Standing
from robolaser.benchmark.standings.phrases import chance
from robolaser.report.comparison.excess import number
from robolaser.report.comparison.plot_context import PlotContext
from robolaser.report.digits import NEVER, count, duration, interval, manifold, many, rate

FEW = 3
"""Problems that have a line each in one cell."""


@final
@dataclass(frozen=True)
class TableCell:
    """What stands in a table, and lines below it in small letters."""

    shown: str
    below: Sequence[str] = ()


@final
@dataclass(frozen=True)
class StandingRow:
    """An algorithm in a family of problems.

    Attributes:
        rank: By evaluations.
        name: Of the algorithm.
        title: Of the algorithm.
        colour: Its line's number in charts, see `report.chart.LINES`; None if it is grey.
        success: Share of runs that reached the target.
        evaluations: To the target.
        seconds: To the target.
        against: Is it significantly worse than the first?
        final: Final results.
        failed: Runs that failed, of those made.
        remark: A caveat.
    """

    rank: str
    name: str
    title: str
    colour: int | None
    success: TableCell
    evaluations: TableCell
    seconds: TableCell
    against: TableCell
    final: TableCell
    failed: str
    remark: str


@final
@dataclass(frozen=True)
class ResultRow:
    """An algorithm on one problem: running time and success at each of the shown targets, and final results."""

    rank: str
    name: str
    colour: int | None
    targets: Sequence[TableCell]
    final: TableCell


def standing_rows(context: PlotContext) -> list[StandingRow]:
    """All algorithms of a family, the best first."""
    by_seconds = {standing.algorithm: standing for standing in context.standings.seconds.places}
    return [
        _standing(context, standing, by_seconds[standing.algorithm])
        for standing in context.standings.evaluations.places
    ]


def _standing(context: PlotContext, standing: Standing, in_seconds: Standing) -> StandingRow:
    name = standing.algorithm
    results = [result for on in context.standings.by_problem for result in on.results if result.algorithm == name]
    at = [(result.problem, one) for result in results if (one := reached(result, context.standings.tolerance))]
    problems = len(context.problems)
    return StandingRow(
        rank=_rank(standing),
        name=name,
        title=context.comparison.solvers[name],
        colour=line_number(context, name),
        success=TableCell(
            "" if standing.success.value is None else rate(standing.success.value),
            _lines(
                _interval(standing.success),
                f"{standing.solved} of {problems} problems" if standing.solved < problems > 1 and standing.runs else "",
            ),
        ),
        evaluations=_price(standing, [(problem, count(_known(one.evaluations))) for problem, one in at]),
        seconds=_price(
            in_seconds,
            [(problem, duration(_known(one.seconds))) for problem, one in at],
            f"rank {_rank(in_seconds)} by time" if in_seconds.rank not in (standing.rank, None) else "",
        ),
        against=_against(standing),
        final=_final(context, [result for result in results if result.final is not None]),
        failed=f"{standing.failed} of {standing.runs}" if standing.failed else "",
        remark=standing.unranked,
    )


def result_rows(context: PlotContext, on: OnProblem) -> list[ResultRow]:
    """All algorithms on a problem, the best first."""
    of = {result.algorithm: result for result in on.results}
    problem = context.contested(on.problem)
    return [
        ResultRow(
            _rank(standing),
            standing.algorithm,
            line_number(context, standing.algorithm),
            [_target(reached(of[standing.algorithm], tolerance), standing.runs) for tolerance in SHOWN],
            _quality(context, problem, of[standing.algorithm]),
        )
        for standing in on.evaluations.places
    ]


def reached(result: Result, tolerance: float) -> Reached | None:
    """What is known of a target."""
    return min(result.targets, key=lambda one: abs(one.tolerance / tolerance - 1.0), default=None)


def line_number(context: PlotContext, name: str) -> int | None:
    """The number of its colour, of an algorithm that has one."""
    coloured = list(context.coloured)
    return coloured.index(name) if name in coloured else None


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


def _price(standing: Standing, each: Sequence[tuple[str, str]], remark: str = "") -> TableCell:
    """The price itself on one problem, times the first's over several."""
    if not standing.runs:
        return TableCell("")
    if not standing.solved:
        return TableCell(NEVER, _lines(remark))
    ratio, between = ("the first", "") if standing.rank == 1 else _ratio(standing.against_first)
    if len(each) == 1:
        return TableCell(each[0][1], _lines(f"{ratio} ({between})" if between else ratio, remark))
    prices_of = [f"{problem} {price}" for problem, price in each] if len(each) <= FEW else []
    return TableCell(ratio or "–", _lines(between, *prices_of, remark))


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


def _against(standing: Standing) -> TableCell:
    pair = standing.against_first
    if pair is None or pair.p_adjusted is None or pair.superiority.value is None:
        return TableCell("")
    return TableCell(
        "yes" if pair.significant else "no",
        (chance(pair.p_adjusted), f"loses {rate(pair.superiority.value)} of pairs"),
    )


def _target(one: Reached | None, runs: int) -> TableCell:
    if one is None or not runs:
        return TableCell("")
    success = f"{one.successes} of {runs} runs"
    if not one.successes:
        return TableCell(NEVER, (success,))
    return TableCell(count(_known(one.evaluations)), (duration(_known(one.seconds)), success))


def _quality(context: PlotContext, problem: ProblemSummary, result: Result) -> TableCell:
    """Median, and quartiles unless they are alike; the violation where most runs found nothing feasible."""
    quality = result.final
    if quality is None:
        return TableCell("")
    if quality.median is None and result.violation is not None:
        return TableCell("nothing feasible", (f"violation {number(result.violation)}",))
    median, lower, upper = (
        context.excess(problem, float("inf") if tolerance is None else tolerance)
        for tolerance in (quality.median, quality.lower_quartile, quality.upper_quartile)
    )
    return TableCell(median, () if median == lower == upper else (f"{lower} to {upper}",))


def _final(context: PlotContext, results: Sequence[Result]) -> TableCell:
    if len(context.problems) == 1 and results:
        return _quality(context, context.problems[0], results[0])
    if len(context.problems) > FEW:
        return TableCell("")
    return TableCell(
        "", [f"{one.problem} {_quality(context, context.contested(one.problem), one).shown}" for one in results]
    )
