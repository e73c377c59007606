"""Thresholds of significance and of effect sizes."""

from robolaser.benchmark.statistics import difference

LEVEL = 0.05
"""Adjusted p below which two solvers differ significantly. In at most one of twenty benchmarks of equal solvers a pair
is called different over a whole family in one measure; the same holds for all pairs on its single problems."""
EFFECTS = ((0.71, "large"), (0.64, "medium"), (0.56, "small"))
"""A12, or 1 − A12, from which on an effect has that name: Vargha & Delaney 2000, table 1."""
NEGLIGIBLE = "negligible"
ENOUGH = 0.5
"""A solver is ranked if it has this share of the largest number of runs on each problem: a block (problem, seed) that
one solver lacks is lost for all."""
MOST_SEEDS = 100
"""More than anybody needs: what is not significant then is not a matter of seeds."""

SCOPE = (
    "Intervals and tests say what new seeds would change on these very problems, with this budget and on this machine. "
    "They do not say how algorithms do on other problems: for that, compare them on more problems."
)


def effect(superiority: float) -> str:
    """Size of an effect in a word."""
    size = max(superiority, 1.0 - superiority)
    return next((word for least, word in EFFECTS if size >= least), NEGLIGIBLE)


def is_significant(p_adjusted: float) -> bool:
    """Whether two solvers differ; never where there is no test."""
    return p_adjusted < LEVEL


def fewest_runs(problems: int, comparisons: int) -> int | None:
    """Runs of each solver on each problem with which the largest possible difference is significant.

    None if `MOST_SEEDS` are too few.
    """
    return next(
        (
            runs
            for runs in range(1, MOST_SEEDS + 1)
            if is_significant(min(1.0, comparisons * difference.smallest(runs, problems)))
        ),
        None,
    )
