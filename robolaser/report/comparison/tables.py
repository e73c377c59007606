"""The tables of a comparison: ranks, results on a problem, pairs, exchanged parts, and what could not be run."""

import math
from collections.abc import Iterable, Mapping, Sequence

import numpy as np

from robolaser.benchmark.problem import ProblemSummary
from robolaser.benchmark.result import BenchmarkResult
from robolaser.benchmark.standings.answer import between, chance, figure, share
from robolaser.benchmark.standings.table import OnProblem, Order, ResultOnProblem, Standing, Standings
from robolaser.report.comparison.words import excess, number, target
from robolaser.report.digits import duration, rate
from robolaser.report.document import Column, Table, TableCell

NEVER = "never"  # for a running time to a target that no run reached
FEW = 8  # algorithms up to which a matrix of pairs is shown expanded
MANY = 8  # problems up to which each has a line in one cell


def standing_table(comparison: BenchmarkResult, standings: Standings, colours: Mapping[str, int], most: int) -> Table:
    """All algorithms of a family, the best first; `most` of them on the terminal."""
    columns = [
        Column("Algorithm", "name", 25, "algorithm"),
        Column("Rank", brief="rank"),
        Column("Success", brief="success"),
        Column("Evaluations to the target (ERT)", brief="evaluations"),
        Column("Significantly worse than the first?", brief="worse than the first?"),
        Column("Failed", brief="failed"),
    ]
    rows = [_standing(comparison, standings, one, colours) for one in standings.order.places]
    shown = [i for i in range(len(columns)) if i < len(columns) - 1 or any(row[i].text for row in rows)]
    note = (
        "Evaluations: the average number to reach the target; over several problems, × times as many as the first where"
        " both reached it, with the 95 % interval."
    )
    return Table([columns[i] for i in shown], [[row[i] for i in shown] for row in rows], note=note, printed=most)


def _standing(
    comparison: BenchmarkResult, standings: Standings, standing: Standing, colours: Mapping[str, int]
) -> list[TableCell]:
    name = standing.algorithm
    results = [result for on in standings.by_problem for result in on.results if result.algorithm == name]
    problems = len(standings.by_problem)
    solved = [f"{standing.solved} of {problems} problems"] if standing.solved < problems > 1 and standing.runs else []
    knows = "knows its budget: searches differently with another" if name in comparison.know_budget else ""
    success = standing.success
    note = "\n".join(filter(None, (standing.unranked, knows)))
    return [
        TableCell(name, below=[comparison.solvers[name]], note=note, line=colours.get(name, -1)),
        _rank(standing),
        TableCell("" if success.value is None else share(success), below=solved, order=success.value),
        _running_time(standing, results),
        _against(standing),
        TableCell(f"{standing.failed} of {standing.runs}" if standing.failed else ""),
    ]


def _rank(standing: Standing) -> TableCell:
    return TableCell("–" if standing.rank is None else str(standing.rank), order=standing.rank or np.inf)


def _running_time(standing: Standing, results: Sequence[ResultOnProblem]) -> TableCell:
    """The ERT on one problem, the ratio to the first's over several; none for an algorithm without success."""
    if not standing.runs:
        return TableCell("")
    if not standing.solved:
        return TableCell(NEVER)
    pair = standing.against_first
    ratio = "" if pair is None or pair.ratio.value is None else f"{figure(pair.ratio.value)} ×{between(pair.ratio)}"
    if len(results) == 1 and (spent := results[0].evaluations).value is not None:
        return TableCell(
            f"{figure(spent.value)}{between(spent) if spent.lower else ''}", [ratio] if ratio else [], order=spent.value
        )
    each = [f"{one.problem} {figure(one.evaluations.value)}" for one in results if one.evaluations.value is not None]
    shown = ratio or ("the first" if standing.rank == 1 else "–")
    return TableCell(shown, each if len(each) <= MANY else [])


def _against(standing: Standing) -> TableCell:
    pair = standing.against_first
    if pair is None or pair.p_adjusted is None or pair.superiority.value is None:
        return TableCell("")
    return TableCell(
        f"{'yes' if pair.significant else 'no'}, {chance(pair.p_adjusted)}",
        (f"loses {rate(pair.superiority.value)} of pairs",),
        order=pair.p_adjusted,
    )


def result_table(problem: ProblemSummary, on: OnProblem, tolerance: float, colours: Mapping[str, int]) -> Table:
    """All algorithms on a problem, the best first: running time, success, and final results."""
    of = {result.algorithm: result for result in on.results}
    rows = [
        [
            TableCell(place.algorithm, line=colours.get(place.algorithm, -1)),
            _rank(place),
            _reached(one),
            TableCell("" if one.run_seconds is None else duration(one.run_seconds)),
            _quality(problem, one),
        ]
        for place in on.order.places
        for one in (of[place.algorithm],)
    ]
    columns = [Column("Algorithm", "name", 23), Column("Rank"), Column("ERT [evaluations]"), Column("Time of a run")]
    columns.append(Column("Final result above the best known: median, quartiles"))
    note = f"Ranked by the target: {target(problem, tolerance)}."
    return Table(columns, rows, "Expected evaluations to the target, and final results", note=note)


def _reached(result: ResultOnProblem) -> TableCell:
    if not result.runs:
        return TableCell("")
    success, spent = f"{result.successes} of {result.runs} runs", result.evaluations.value
    return TableCell(NEVER if spent is None else figure(spent), (success,), order=spent)


def _quality(problem: ProblemSummary, result: ResultOnProblem) -> TableCell:
    """Median, and quartiles unless equal; the violation if most runs found nothing feasible."""
    if result.final is None:
        return TableCell("")
    if result.final["median"] is None and result.violation is not None:
        return TableCell("nothing feasible", (f"violation {number(result.violation)}",))
    ends = [result.final[end] for end in ("lower_quartile", "median", "upper_quartile")]
    lower, median, upper = (excess(problem, math.inf if end is None else end) for end in ends)
    return TableCell(median, () if lower == upper else (f"{lower} to {upper}",), order=ends[1])


def pairwise_matrix(order: Order) -> Table:
    """Algorithms in order, pairwise."""
    names = [standing.algorithm for standing in order.places]
    rows = [[TableCell(f"{i} {one}"), *(_pair(order, one, other) for other in names)] for i, one in enumerate(names, 1)]
    note = (
        "A12: probability that a run of the row's algorithm does better than one of the column's. Star: significant"
        " after Holm's correction. Blue: the row's is better; orange: the column's."
    )
    columns = [Column("Row beats column"), *(Column(str(i)) for i in range(1, len(names) + 1))]
    return Table(columns, rows if len(names) > 1 else [], "Pairwise comparison", note, FEW, kind="matrix")


def _pair(order: Order, one: str, other: str) -> TableCell:
    if one == other:
        return TableCell("·")
    pair = next((pair for pair in order.pairs if {pair.one, pair.other} == {one, other}), None)
    if pair is None or pair.superiority.value is None:
        return TableCell(hint="nothing is known of these two")
    value = pair.superiority.value if pair.one == one else 1.0 - pair.superiority.value
    p = "" if pair.p_adjusted is None else f", {chance(pair.p_adjusted)}"
    significant = "significant" if pair.significant else "not significant"
    hint = f"{one} beats {other} in {100 * value:.0f} % of pairs; {significant}{p}"
    star = "*" if pair.significant else ""
    return TableCell(f"{value:.2f}{star}", order=value, lean=200 * (value - 0.5), hint=hint)


def effect_table(standings: Standings) -> Table:
    """A row for each exchanged operator."""
    columns = [
        Column("Operator", "name", 30, "operator"),
        Column("In place of", "text"),
        Column("Share of pairs of runs in which it is better", brief="better in"),
        Column("Ratio of evaluations", brief="times the evaluations"),
        Column("p", brief="p"),
    ]
    rows = [
        (
            TableCell(f"{effect.operator} as {effect.slot}"),
            f"{effect.stock}'s own",
            TableCell(share(effect.superiority), order=effect.superiority.value),
            TableCell(
                "–" if effect.ratio.value is None else f"{figure(effect.ratio.value)}{between(effect.ratio)}",
                order=effect.ratio.value,
            ),
            TableCell(chance(effect.p_adjusted), order=effect.p_adjusted),
        )
        for effect in standings.effects
    ]
    note = (
        "Runs with the operator against otherwise equal runs without it, with 95 % intervals: 50 % of pairs is no"
        " effect; below 1 it reaches the target faster. p: van Elteren's test, by Holm for all operators."
    )
    return Table(columns, rows, "What each exchanged operator does", note, printed=len(rows))


def by_reason(found: Iterable[tuple[str, str, str]]) -> list[tuple[str, str, int, str]]:
    """Algorithm and reason, with the number of problems and those that differ, of algorithms, reasons and problems."""
    grouped: dict[tuple[str, str], list[str]] = {}
    for name, reason, problem in found:
        grouped.setdefault((name, reason), []).append(problem)
    return [(name, reason, len(on), ", ".join(dict.fromkeys(on))) for (name, reason), on in grouped.items()]
