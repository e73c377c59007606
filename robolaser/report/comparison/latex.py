"""A comparison as LaTeX tables for a paper (booktabs)."""

import re
from collections.abc import Sequence

from robolaser.benchmark.result import BenchmarkResult
from robolaser.benchmark.standings.answer import chance, figure
from robolaser.benchmark.standings.table import OnProblem, ResultOnProblem, Standing, Standings
from robolaser.report.comparison.words import FAMILIES, budget, excess, target
from robolaser.report.digits import rate

FILE = "tables.tex"
NONE = "--"  # for a missing number
RAISED = "⁻⁰¹²³⁴⁵⁶⁷⁸⁹"
LOWERED = str.maketrans(RAISED, "-0123456789")
SPECIAL = {  # characters that LaTeX would take for commands, or a font may lack
    "\\": r"\textbackslash{}", "~": r"\textasciitilde{}", "^": r"\textasciicircum{}", "∞": r"$\infty$", "–": "--",
    "×": r"\texttimes{}", "<": r"\textless{}", ">": r"\textgreater{}", **{sign: f"\\{sign}" for sign in "&%$#_{}"},
}  # fmt: skip


def latex_tables(result: BenchmarkResult, judged: Sequence[Standings]) -> str:
    """Tables of each family, by its standings: the ranking, and medians and expected running times on each problem."""
    made = []
    for standings in judged:
        places = [place for place in standings.order.places if place.runs]
        if not places:
            continue
        targets = (f"Target on {one.name}: {target(one, standings.tolerance)}." for one in result.of(standings.family))
        names, problems = [place.algorithm for place in places], {one.name: one for one in result.problems}
        made += [
            latex(
                f"{FAMILIES[standings.family]} ({len(standings.by_problem)}), {standings.seeds} seeds,"
                f" {budget(result)} a run. {' '.join(targets)} ERT ratio: that of expected running"
                " times to the target against the first, where both reached it, with 95 % intervals; p by Holm.",
                ("Algorithm", "Rank", "Mean rank", "Success", "ERT ratio", "p"),
                [_place(place) for place in places],
            ),
            latex(
                "Median of the runs' results above the lowest known.",
                ("Problem", *names),
                [(on.problem, *(excess(problems[on.problem], _median(one)) for one in _of(on, names)))
                 for on in standings.by_problem],
            ),
            latex(
                "Expected running time in evaluations to the target (runs that reached it/runs).",
                ("Problem", *names),
                [(on.problem, *map(_ert, _of(on, names))) for on in standings.by_problem],
            ),
        ]  # fmt: skip
    return "\n".join(made)


def latex(title: str, columns: Sequence[str], rows: Sequence[Sequence[str]]) -> str:
    """A table."""
    head, *body = (f"{' & '.join(map(_escaped, line))} \\\\" for line in (columns, *rows))
    return "\n".join(
        [
            r"\begin{table}", r"\centering", f"\\caption{{{_escaped(title)}}}",
            f"\\begin{{tabular}}{{l{'r' * (len(columns) - 1)}}}", r"\toprule", head, r"\midrule", *body,
            r"\bottomrule", r"\end{tabular}", r"\end{table}", "",
        ]
    )  # fmt: skip


def _escaped(text: str) -> str:
    return "".join(
        f"\\textsuperscript{{{part.translate(LOWERED)}}}" if i % 2 else "".join(SPECIAL.get(one, one) for one in part)
        for i, part in enumerate(re.split(f"([{RAISED}]+)", text))
    )


def _place(place: Standing) -> tuple[str, ...]:
    pair, success, ratio, p = place.against_first, place.success, NONE, NONE
    if pair is not None and pair.ratio.value is not None:
        lower, upper = pair.ratio.lower, pair.ratio.upper
        ends = "" if lower is None else f" [{figure(lower)}, {'∞' if upper is None else figure(upper)}]"
        ratio = f"{figure(pair.ratio.value)}{ends}"
    if pair is not None and pair.p_adjusted is not None:
        p = chance(pair.p_adjusted).removeprefix("p ").removeprefix("= ")
    share = NONE if success.value is None else f"{rate(success.value)}"
    if success.lower is not None and success.upper is not None:
        share += f" [{rate(success.lower)}, {rate(success.upper)}]"
    rank = NONE if place.rank is None else str(place.rank)
    return place.algorithm, rank, NONE if place.mean_rank is None else f"{place.mean_rank:.2f}", share, ratio, p


def _of(on: OnProblem, names: Sequence[str]) -> list[ResultOnProblem | None]:
    by_name = {one.algorithm: one for one in on.results}
    return [by_name.get(name) for name in names]


def _median(result: ResultOnProblem | None) -> float:
    if result is None or result.final is None:
        return float("nan")
    return float("inf") if result.final["median"] is None else result.final["median"]


def _ert(result: ResultOnProblem | None) -> str:
    if result is None or not result.runs:
        return NONE
    spent = NONE if result.evaluations.value is None else figure(result.evaluations.value)
    return f"{spent} ({result.successes}/{result.runs})"
