"""An ablation study of the 2004 paper: three comparisons, the tables of README.md, and its chart.

Runs are kept in build/ablation and not repeated; `--page` only writes the tables and the chart from them.
"""

import argparse
import json
import re
import subprocess
import sys
from collections.abc import Iterator
from importlib.resources import files
from pathlib import Path
from typing import Any

import vl_convert

from robolaser import load_comparison
from robolaser.benchmark.standings.ranking import standings
from robolaser.report.chart import CONFIG
from robolaser.report.comparison.page import solved

ROOT = Path(__file__).parents[2]
FOLDER = ROOT / "build" / "ablation"
PAGE = Path(__file__).with_name("README.md")
PICTURES = ROOT / "docs" / "pictures"
ROBOLASER = Path(sys.executable).with_name("robolaser")
PROBLEMS = ("paper", "reduced:paper")
SEEDS = 30
WIDTH_PX = 520

PARTS = {
    "operators": (
        50_000,
        (
            "ga",
            "ga:crossover=ArithmeticCrossover",
            "ga:mutation=NonUniformMutation",
            "ga:selection=RouletteSelection",
            "ga:survival=ElitistReplacement:survival.n_elites=10",
            "ga:crossover=ArithmeticCrossover:mutation=NonUniformMutation",
            "rcga",
        ),
    ),
    "field": (
        20_000,
        (
            "screening", "rcga", "ga", "de", "pso", "es", "isres", "g3pcx", "cmaes", "nelder-mead", "pattern-search",
            "pycma", "least-squares", "scipy-de", "random",
        ),
    ),
    "settings": (
        300_000,
        (
            "rcga", "rcga:b=1", "rcga:b=2", "rcga:b=10", "rcga:prob_var=0.03", "rcga:prob_var=0.3",
            "rcga:prob_crossover=0.5", "rcga:prob_crossover=1", "rcga:n_elites=0", "rcga:n_elites=1",
            "rcga:n_elites=50", "rcga:pop_size=50", "rcga:pop_size=200",
        ),
    ),
}  # fmt: skip
"""Budget and solvers of each comparison."""
PICTURED = "field"
BESIDE = {"operators": "ga", "field": "rcga", "settings": "rcga"}
"""The solver that the others are compared with."""
COLUMNS = ("algorithm", "within 1 % of the best J", "evaluations to it", "J at the end, median")


def command(part: str) -> list[str]:
    budget, algorithms = PARTS[part]
    words = ["robolaser", "compare", *PROBLEMS, "--algorithms", ",".join(algorithms), "--seeds", str(SEEDS)]
    return [*words, "--budget", str(budget), "--output", part]


def compare(part: str) -> None:
    """Make the missing runs."""
    _, *words = command(part)
    subprocess.run([ROBOLASER, *words, "--resume"], cwd=FOLDER, check=True)


def main() -> None:
    options = argparse.ArgumentParser(description=__doc__)
    options.add_argument("parts", nargs="*", default=list(PARTS), help=f"of {', '.join(PARTS)}; default: all")
    options.add_argument("--page", action="store_true", help="only write the tables and the chart")
    args = options.parse_args()
    FOLDER.mkdir(parents=True, exist_ok=True)
    for part in () if args.page else args.parts:
        compare(part)
    text = PAGE.read_text()
    for part in args.parts:
        made = "\n".join(shown(part, json.loads((FOLDER / part / "comparison.json").read_text())))
        pattern = rf"(<!-- made: {part} -->\n).*?(<!-- end -->)"
        text, found = re.subn(pattern, lambda m, made=made: f"{m[1]}{made}\n{m[2]}", text, flags=re.DOTALL)
        assert found, part
    PAGE.write_text(text)
    if PICTURED in args.parts:
        PICTURES.joinpath(f"ablation-{PICTURED}-evaluations.svg").write_text(picture(PICTURED))


def picture(part: str) -> str:
    """The ECDF of running times from the report, in the colours of its light style."""
    comparison = load_comparison(FOLDER / part).benchmark
    drawn = solved(comparison, standings(comparison, "calibration"), "Targets reached by evaluations")
    assert drawn is not None
    style = files("robolaser").joinpath("report/templates/style.css").read_text()
    colours = dict(reversed(re.findall(r"(--[\w-]+): (#\w+)", style)))  # the first definition of each is the light one
    spec = drawn.spec | {"width": WIDTH_PX, "config": CONFIG | {"background": "white", "font": "sans-serif"}}
    text = re.sub(r"var\((--[\w-]+)\)", lambda m: colours[m[1]], json.dumps(spec))
    return str(vl_convert.vegalite_to_svg(json.loads(text))) + "\n"


def shown(part: str, comparison: dict[str, Any]) -> Iterator[str]:
    """The command and the results of a comparison, as Markdown."""
    beside = BESIDE[part]
    yield "```text"
    yield " ".join(command(part))
    yield "```"
    (family,) = comparison["standings"]
    for on in family["by_problem"]:
        yield ""
        yield f"**`{on['problem']}`**"
        yield ""
        yield f"| {' | '.join(('', *COLUMNS, f'beats `{beside}` in'))} |"
        yield "|---" * (2 + len(COLUMNS)) + "|"
        finals = {result["algorithm"]: result["final"] for result in on["results"]}
        pairs = {(pair["one"], pair["other"]): pair for pair in on["order"]["pairs"]}
        for row in on["order"]["places"]:
            name = row["algorithm"]
            price = row["running_time"]["value"]
            cells = (
                str(row["rank"] or ""),
                f"`{name}`",
                f"{round(row['success']['value'] * row['runs'])} of {row['runs']}",
                "never" if price is None else f"{float(f'{price:.3g}'):,.0f}",
                _above_best(finals[name]["median"]),
                _beats(pairs, name, beside),
            )
            yield f"| {' | '.join(cells)} |"


def _beats(pairs: dict[tuple[str, str], dict[str, Any]], name: str, beside: str) -> str:
    """Share of pairs of runs in which a solver is better than another; bold if they differ significantly."""
    if name == beside:
        return ""
    pair = pairs.get((name, beside)) or pairs[beside, name]
    share = pair["superiority"]["value"] if pair["one"] == name else 1 - pair["superiority"]["value"]
    text = f"{100 * share:.0f} %"
    return f"**{text}**" if pair["significant"] else text


def _above_best(tolerance: float | None) -> str:
    """J relative to the best known."""
    if tolerance is None:
        return ""
    if tolerance < 1e-6:
        return "the best"
    return (
        f"{float(f'{1 + tolerance:.3g}'):,g} × the best" if tolerance >= 0.01 else f"the best + {100 * tolerance:.1g} %"
    )


if __name__ == "__main__":
    main()
