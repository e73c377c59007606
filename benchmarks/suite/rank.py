"""Fifteen algorithms on the suite: the tables of README.md.

`--page` only writes the tables, from the existing runs in build/suite.
"""

import argparse
import json
import re
import subprocess
import sys
from collections.abc import Iterator
from pathlib import Path

import numpy as np
from landscape import landscape
from scipy.stats import binomtest

from robolaser.problems import suite

ROOT = Path(__file__).parents[2]
FOLDER = ROOT / "build" / "suite"
PAGE = Path(__file__).with_name("README.md")
SEEDS, BUDGET = 3, 1000
ALGORITHMS = (
    "screening", "rcga", "ga", "de", "pso", "es", "isres", "g3pcx", "cmaes", "nelder-mead", "pattern-search", "pycma",
    "least-squares", "scipy-de", "random",
)  # fmt: skip
COMMAND = (
    f"robolaser compare suite --algorithms {','.join(ALGORITHMS)} --seeds {SEEDS} --budget {BUDGET} --output ranking"
)


def main() -> None:
    """Make the missing runs, and write the tables."""
    options = argparse.ArgumentParser(description=__doc__)
    options.add_argument("--page", action="store_true", help="only write the tables")
    if not options.parse_args().page:
        FOLDER.mkdir(parents=True, exist_ok=True)
        words = [sys.executable, "-m", *COMMAND.split(), "--resume", "--jobs", "2"]
        subprocess.run(words, cwd=FOLDER, check=True)
    for part, rows in (("ranking", ranking()), ("instances", table())):
        made = "\n".join(rows)
        text, found = re.subn(
            rf"(<!-- made: {part} -->\n).*?(<!-- end -->)",
            lambda m, made=made: f"{m[1]}{made}\n{m[2]}",
            PAGE.read_text(),
            flags=re.DOTALL,
        )
        assert found, part
        PAGE.write_text(text)


def ranking() -> Iterator[str]:
    """The table of algorithms."""
    result = json.loads((FOLDER / "ranking" / "comparison.json").read_text())
    (family,) = result["standings"]
    best = {problem["name"]: problem["best"] for problem in result["problems"]}
    known = {f"suite:{one.id}": one.lowest for one in suite()}
    lower = [name for name in best if best[name] < known[name] * (1 - 1e-6)]
    assert not lower, f"beaten: {lower}"
    yield "```text"
    yield COMMAND
    yield "```"
    yield ""
    yield "| | algorithm | mean rank | runs within 1 % of the lowest J | instances where any was |"
    yield "|---|---|---|---|---|"
    for row in family["order"]["places"]:
        success = row["success"]
        shares = [f"{100 * success[key]:.0f}" for key in ("value", "lower", "upper")]
        yield (
            f"| {row['rank'] or ''} | `{row['algorithm']}` | {row['mean_rank']:.1f} |"
            f" {shares[0]} % ({shares[1]} to {shares[2]} %) | {row['solved']} of {len(best)} |"
        )


def table() -> Iterator[str]:
    """The table of instances."""
    yield (
        "| instance | d | gauge | lowest J | descents that reach it | condition number | fitness-distance correlation |"
        " dispersion | poles | median J |"
    )
    yield "|---" * 10 + "|"
    for problem in suite():
        one, instance = landscape(problem), problem.instance
        share = binomtest(instance.reached, instance.starts).proportion_ci(method="wilson")
        yield (
            f"| `{problem.id}`: {problem.title} | {problem.dimension} | {one['gauge']} | {problem.lowest:.4g}"
            f" {problem.model.blocks.unit}² | {instance.reached} of {instance.starts}"
            f" ({100 * share.low:.0f} to {100 * share.high:.0f} %) | 1e{np.log10(one['condition']):.0f}"
            f" | {one['correlation']:.2f} | {one['dispersion']:.2f} | {100 * one['poles']:.0f} %"
            f" | 1e{np.log10(one['median']):.0f} |"
        )


if __name__ == "__main__":
    main()
