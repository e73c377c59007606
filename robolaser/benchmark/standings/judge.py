"""The judge's thresholds, and what follows from them in a word."""

from robolaser.benchmark.statistics import difference

LEVEL = 0.05
"""Adjusted p below which two contestants are told apart: what is said of all pairs over a whole family in one measure
is right in nineteen comparisons of twenty, and so is what is said of all pairs on its single problems."""
EFFECTS = ((0.71, "large"), (0.64, "medium"), (0.56, "small"))
"""A12, or one less it, from which on an effect is called so: Vargha & Delaney 2000, table 1."""
NEGLIGIBLE = "negligible"
ENOUGH = 0.5
"""Share of the runs of those who have most, on each problem, from which on a contestant is ranked: every block that one
lacks is lost to all the others too."""
MOST_SEEDS = 100
"""More than anybody asks for; what cannot be told with so many is not a matter of seeds."""

SCOPE = (
    "Intervals and tests say what new seeds would change on these very problems, with this budget and on this machine. "
    "They do not say how contestants do on other problems: for that, compare them on more data sets. "
    "What is said of two contestants rests on all their runs against each other; the critical difference of mean ranks "
    "looks at everybody at once and is usually more cautious: it may leave two in one group whom the runs tell apart."
)


def effect(superiority: float) -> str:
    """Size of an effect in a word."""
    size = max(superiority, 1.0 - superiority)
    return next((word for least, word in EFFECTS if size >= least), NEGLIGIBLE)


def told(p_adjusted: float) -> bool:
    """Can two contestants be told apart? Not where there is no test."""
    return p_adjusted < LEVEL


def fewest_runs(problems: int, comparisons: int) -> int | None:
    """Runs of each on each problem, with which the largest difference there is can be told among so many comparisons.

    None where even `MOST_SEEDS` would not do.
    """
    return next(
        (
            runs
            for runs in range(1, MOST_SEEDS + 1)
            if told(min(1.0, comparisons * difference.smallest(runs, problems)))
        ),
        None,
    )
