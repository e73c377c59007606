"""A comparison as tables for a paper, in LaTeX (booktabs) or Markdown."""

import re
from collections.abc import Sequence
from typing import Literal

from robolaser.benchmark.result import BenchmarkResult
from robolaser.benchmark.standings import Standings
from robolaser.benchmark.standings.answer import chance, figure
from robolaser.benchmark.standings.table import OnProblem, Result, Standing
from robolaser.report.comparison.words import FAMILIES, aims, budget, excess
from robolaser.report.digits import rate

Form = Literal["latex", "markdown"]
FILES: dict[Form, str] = {"latex": "tables.tex", "markdown": "tables.md"}
"""The file of each form."""
NONE = "--"
"""Where there is no number."""
RAISED = "⁻⁰¹²³⁴⁵⁶⁷⁸⁹"
LOWERED = str.maketrans(RAISED, "-0123456789")
SPECIAL = {
    "\\": r"\textbackslash{}", "~": r"\textasciitilde{}", "^": r"\textasciicircum{}", "∞": r"$\infty$", "–": "--",
    "×": r"\texttimes{}", "<": r"\textless{}", ">": r"\textgreater{}", **{sign: f"\\{sign}" for sign in "&%$#_{}"},
}  # fmt: skip
"""What LaTeX would take for a command, or a font may lack."""


def paper_tables(result: BenchmarkResult, judged: Sequence[Standings], form: Form) -> str:
    """Tables of each family: the ranking, and medians and expected running times on each problem.

    Args:
        result: What was run.
        judged: The standings of each family.
        form: The language.
    """
    written = latex if form == "latex" else markdown
    made = []
    for standings in judged:
        places = [place for place in standings.order.places if place.runs]
        if not places:
            continue
        names, problems = [place.algorithm for place in places], {one.name: one for one in result.problems}
        made += [
            written(
                f"{FAMILIES[standings.family]} ({len(standings.by_problem)}), {standings.seeds} seeds,"
                f" {budget(result)} a run. {' '.join(aims(result, standings))} ERT ratio: that of expected running"
                " times to the target against the first, where both reached it, with 95 % intervals; p by Holm.",
                ("Algorithm", "Rank", "Mean rank", "Success", "ERT ratio", "p"),
                [_place(place) for place in places],
            ),
            written(
                "Median of the runs' results above the lowest known.",
                ("Problem", *names),
                [(on.problem, *(excess(problems[on.problem], _median(one)) for one in _of(on, names)))
                 for on in standings.by_problem],
            ),
            written(
                "Expected running time in evaluations to the target (runs that reached it/runs).",
                ("Problem", *names),
                [(on.problem, *map(_ert, _of(on, names), [standings.tolerance] * len(names)))
                 for on in standings.by_problem],
            ),
        ]  # fmt: skip
    return "\n".join(made)


def markdown(title: str, columns: Sequence[str], rows: Sequence[Sequence[str]]) -> str:
    """A table; bars in its cells do not part them."""
    lines = [columns, ["---", *["--:"] * (len(columns) - 1)], *rows]
    parted = (" | ".join(cell.replace("|", "\\|") for cell in line) for line in lines)
    return "\n".join([title, "", *(f"| {line} |" for line in parted), ""])


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
    pair = place.against_first
    ratio = NONE
    if pair is not None and pair.ratio.value is not None:
        lower, upper = pair.ratio.lower, pair.ratio.upper
        ends = "" if lower is None else f" [{figure(lower)}, {'∞' if upper is None else figure(upper)}]"
        ratio = f"{figure(pair.ratio.value)}{ends}"
    success = place.success
    share = NONE if success.value is None else f"{rate(success.value)}"
    if success.lower is not None and success.upper is not None:
        share += f" [{rate(success.lower)}, {rate(success.upper)}]"
    return (
        place.algorithm,
        NONE if place.rank is None else str(place.rank),
        NONE if place.mean_rank is None else f"{place.mean_rank:.2f}",
        share,
        ratio,
        NONE
        if pair is None or pair.p_adjusted is None
        else chance(pair.p_adjusted).removeprefix("p ").removeprefix("= "),
    )


def _of(on: OnProblem, names: Sequence[str]) -> list[Result | None]:
    by_name = {one.algorithm: one for one in on.results}
    return [by_name.get(name) for name in names]


def _median(result: Result | None) -> float:
    if result is None or result.final is None:
        return float("nan")
    return float("inf") if result.final["median"] is None else result.final["median"]


def _ert(result: Result | None, tolerance: float) -> str:
    if result is None or not result.runs:
        return NONE
    reached = next(one for one in result.targets if one.tolerance == tolerance)
    spent = NONE if reached.evaluations is None else figure(reached.evaluations)
    return f"{spent} ({reached.successes}/{result.runs})"
