"""A comparison as tables for a paper, in LaTeX (booktabs) or Markdown."""

import math
import re
from collections.abc import Callable, Sequence
from typing import TYPE_CHECKING, Literal

from robolaser.benchmark.fixed import fixed_budget, fixed_target
from robolaser.benchmark.result import BenchmarkResult
from robolaser.benchmark.standings import Standings
from robolaser.benchmark.standings.answer import figure
from robolaser.benchmark.standings.table import Standing
from robolaser.benchmark.statistics.intervals import IntervalEstimate
from robolaser.benchmark.statistics.signed_rank import ROPE, signed_rank
from robolaser.report.comparison.plot_context import target
from robolaser.report.digits import percent, rate

if TYPE_CHECKING:
    import pandas as pd

Form = Literal["latex", "markdown"]
FILES: dict[Form, str] = {"latex": "tables.tex", "markdown": "tables.md"}
"""The file of each form."""
NONE = "--"
"""Where there is no number."""
SPECIAL = {
    "\\": r"\textbackslash{}", "~": r"\textasciitilde{}", "^": r"\textasciicircum{}", "²": r"\textsuperscript{2}",
    "×": r"\texttimes{}", "<": r"\textless{}", ">": r"\textgreater{}", **{sign: f"\\{sign}" for sign in "&%$#_{}"},
}  # fmt: skip
"""What LaTeX would take for a command, or a font may lack."""


def paper_tables(result: BenchmarkResult, judged: Sequence[Standings], form: Form) -> str:
    """Tables of each family: ranking, costs at the whole budget, times to the target, Bayesian signed-rank test.

    Args:
        result: What was run.
        judged: The standings of each family.
        form: The language.
    """
    written = latex if form == "latex" else markdown
    tables = []
    for standings in judged:
        aim, names = target(standings.family, standings.tolerance), [place.algorithm for place in _places(standings)]
        if not names:
            continue
        problems = [on.problem for on in standings.by_problem]
        tables.append(
            written(
                f"Ranking on {standings.family} problems ({len(problems)}) with {standings.seeds} seeds; success is"
                f" {aim}, ERT ratio that of expected running times to it in evaluations, against the first, with 95 %"
                " intervals; p by Holm.",
                ("Algorithm", "Rank", "Mean rank", "Success", "ERT ratio", "p"),
                [_standing(place) for place in _places(standings)],
            )
        )
        budgets, targets = (
            fixed_budget(result, [result.budget]),
            fixed_target(result, standings.family, [standings.tolerance]),
        )
        columns = ("Problem", *names)
        tables += [
            written(
                f"Median cost above the lowest known after {result.budget} evaluations, over the problem's scale.",
                columns,
                _grid(budgets, problems, names, "median", lambda row: _power(row["median"])),
            ),
            written(
                f"Expected running time in evaluations to {aim} (runs that reached it/runs).",
                columns,
                _grid(
                    targets, problems, names, "ert", lambda row: f"{_number(row['ert'])} ({row.successes}/{row.runs})"
                ),
            ),
        ]
        tested = signed_rank(result.arrays(standings.family))
        if len(problems) > 1 and len(tested):
            tables.append(
                written(
                    "Bayesian signed-rank test over problems: probability that the one is better, that both are alike"
                    f" (A12 within {ROPE} of a half), and that the other is better.",
                    ("Algorithm", "Other", "Better", "Alike", "Worse"),
                    [(r.algorithm, r.other, *map(percent, (r.better, r.alike, r.worse))) for r in tested.itertuples()],
                )
            )
    return "\n".join(tables)


def markdown(title: str, columns: Sequence[str], rows: Sequence[Sequence[str]]) -> str:
    """A table; `**bold**` in its cells stays, bars in them do not part cells."""
    lines = [columns, ["---", *["--:"] * (len(columns) - 1)], *rows]
    parted = (" | ".join(cell.replace("|", "\\|") for cell in line) for line in lines)
    return "\n".join([title, "", *(f"| {line} |" for line in parted), ""])


def latex(title: str, columns: Sequence[str], rows: Sequence[Sequence[str]]) -> str:
    """A table; `**bold**` in its cells becomes a command."""
    head, *body = (f"{' & '.join(map(_escaped, line))} \\\\" for line in (columns, *rows))
    return "\n".join(
        [
            r"\begin{table}", r"\centering", f"\\caption{{{_escaped(title)}}}",
            f"\\begin{{tabular}}{{l{'r' * (len(columns) - 1)}}}", r"\toprule", head, r"\midrule", *body,
            r"\bottomrule", r"\end{tabular}", r"\end{table}", "",
        ]
    )  # fmt: skip


def _escaped(text: str) -> str:
    plain = "".join(SPECIAL.get(letter, letter) for letter in text)
    return re.sub(r"\*\*(.+?)\*\*", r"\\textbf{\1}", plain)


def _places(standings: Standings) -> Sequence[Standing]:
    return [place for place in standings.evaluations.places if place.runs]


def _standing(place: Standing) -> tuple[str, ...]:
    pair = place.against_first
    p = None if pair is None else pair.p_adjusted
    return (
        place.algorithm,
        NONE if place.rank is None else str(place.rank),
        NONE if place.mean_rank is None else f"{place.mean_rank:.2f}",
        _between(place.success, rate),
        "1" if pair is None and place.rank == 1 else NONE if pair is None else _between(pair.ratio, figure),
        NONE if p is None else "< 0.001" if p < 1e-3 else f"{p:.2g}",
    )


def _between(estimate: IntervalEstimate, shown: Callable[[float], str]) -> str:
    if estimate.value is None:
        return NONE
    if estimate.lower is None:
        return shown(estimate.value)
    upper = "open" if estimate.upper is None else shown(estimate.upper)
    return f"{shown(estimate.value)} [{shown(estimate.lower)}, {upper}]"


def _grid(
    frame: "pd.DataFrame", problems: Sequence[str], names: Sequence[str], by: str, shown: Callable[["pd.Series"], str]
) -> list[list[str]]:
    """Problems against algorithms, the lowest of a row in bold."""
    of = {(row.problem, row.algorithm): row for _, row in frame.iterrows()}
    grid = []
    for problem in problems:
        cells = [of.get((problem, name)) for name in names]
        lowest = min((cell[by] for cell in cells if cell is not None), default=math.inf)
        texts = [NONE if cell is None else shown(cell) for cell in cells]
        best = [cell is not None and cell[by] == lowest < math.inf for cell in cells]
        grid.append([problem, *(f"**{text}**" if wins else text for text, wins in zip(texts, best, strict=True))])
    return grid


def _number(value: float) -> str:
    return f"{value:.0f}" if math.isfinite(value) else NONE


def _power(value: float) -> str:
    return f"{value:.2e}" if math.isfinite(value) else NONE
