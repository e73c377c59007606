"""The 2004 paper taken apart: three comparisons, and the page of the docs that shows what they say.

Runs are kept in build/ablation and not made again; `--page` only writes the page from what is there.
"""

import argparse
import json
import re
import subprocess
import sys
from collections.abc import Iterator
from pathlib import Path
from typing import Any

ROOT = Path(__file__).parents[2]
FOLDER = ROOT / "build" / "ablation"
PAGE = ROOT / "docs" / "ablation.md"
ROBOLASER = Path(sys.executable).with_name("robolaser")
PROBLEMS = ("paper", "reduced:paper")
SEEDS = 30

PARTS = {
    "operators": (
        50_000,
        (
            "ga",
            "ga:crossover=arithmetic",
            "ga:mutation=non-uniform",
            "ga:selection=roulette",
            "ga:survival=elitist",
            "ga:crossover=arithmetic:mutation=non-uniform",
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
            "rcga", "rcga:b=1", "rcga:b=2", "rcga:b=10", "rcga:form=power", "rcga:prob_var=0.03", "rcga:prob_var=0.3",
            "rcga:prob_crossover=0.5", "rcga:prob_crossover=1", "rcga:n_elites=0", "rcga:n_elites=1",
            "rcga:n_elites=50", "rcga:pop_size=50", "rcga:pop_size=200",
        ),
    ),
}  # fmt: skip
"""Budget and contestants of each comparison."""
COLUMNS = ("contestant", "within 1 % of the best J", "evaluations to it", "times the first's", "J at the end, median")


def command(part: str) -> list[str]:
    budget, algorithms = PARTS[part]
    words = ["robolaser", "compare", *PROBLEMS, "--algorithms", ",".join(algorithms), "--seeds", str(SEEDS)]
    return [*words, "--budget", str(budget), "--output", part]


def compare(part: str) -> None:
    """Make the runs that are not there yet."""
    _, *words = command(part)
    subprocess.run([ROBOLASER, *words, "--resume"], cwd=FOLDER, check=True)


def main() -> None:
    options = argparse.ArgumentParser(description=__doc__)
    options.add_argument("parts", nargs="*", default=list(PARTS), help=f"of {', '.join(PARTS)}; default: all")
    options.add_argument("--page", action="store_true", help="only write the page")
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


def shown(part: str, said: dict[str, Any]) -> Iterator[str]:
    """What the tool says of a comparison, as Markdown."""
    yield "```text"
    yield " ".join(command(part))
    yield "```"
    (family,) = said["standings"]
    for on in family["by_problem"]:
        yield ""
        yield f"**{on['problem']}.** {on['evaluations']['answer']}"
        yield ""
        yield f"| {' | '.join(('', *COLUMNS))} |"
        yield "|---" * (1 + len(COLUMNS)) + "|"
        finals = {result["algorithm"]: result["final"] for result in on["results"]}
        for place in on["evaluations"]["places"]:
            yield "| " + " | ".join(_cells(place, finals[place["algorithm"]])) + " |"


def _cells(place: dict[str, Any], final: dict[str, Any] | None) -> Iterator[str]:
    yield str(place["rank"] or "")
    yield f"`{place['algorithm']}`"
    yield f"{round(place['success']['value'] * place['runs'])} of {place['runs']}" if place["runs"] else ""
    price = place["price"]["value"]
    yield "never" if price is None else f"{price:,.0f}"
    against = place["against_first"]
    if against is None:
        yield "the first"
    else:
        ratio = against["ratio"]
        told = "" if against["told"] else ", not told apart"
        times = "" if ratio["value"] is None else f"{ratio['value']:.2g}"
        if times and ratio["lower"] and ratio["upper"]:
            times += f" ({ratio['lower']:.2g} to {ratio['upper']:.2g})"
        yield (times or f"p {_p(against['p_adjusted'])}") + told
    yield (
        ""
        if final is None or final["median"] is None
        else f"{1 + final['median']:.3g} ×"
        if final["median"] >= 0.01
        else f"1 + {final['median']:.1g}"
    )


def _above_best(tolerance: float | None) -> str:
    """J in units of the best known."""
    if tolerance is None:
        return ""
    return f"{1 + tolerance:.3g} times the best" if tolerance >= 0.01 else f"the best + {100 * tolerance:.1g} %"


def _p(value: float | None) -> str:
    return "unknown" if value is None else "< 0.001" if value < 1e-3 else f"= {value:.2g}"


if __name__ == "__main__":
    main()
