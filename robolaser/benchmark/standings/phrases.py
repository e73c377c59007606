"""Numbers and names as parts of a sentence."""

from collections.abc import Sequence

from robolaser.benchmark.standings.table import Measure
from robolaser.benchmark.statistics.intervals import IntervalEstimate

MANY = 3
"""Names that a sentence lists before it counts the others."""


def figure(number: float) -> str:
    """Two digits: 1,200, 3.1, 0.045."""
    rounded = float(f"{number:.2g}")
    return f"{rounded:,.0f}" if rounded >= 10 else f"{rounded:g}"


def chance(p: float) -> str:
    """A probability, as `p = 0.013`."""
    return "p < 0.001" if p < 1e-3 else f"p = {p:.2g}"


def share(estimate: IntervalEstimate) -> str:
    """A share with its interval, as `80 % (49 to 94 %)`."""
    if estimate.value is None:
        return "an unknown share"
    if estimate.lower is None or estimate.upper is None:
        return f"{estimate.value:.0%}".replace("%", " %")
    return f"{100 * estimate.value:.0f} % ({100 * estimate.lower:.0f} to {100 * estimate.upper:.0f} %)"


def between(estimate: IntervalEstimate) -> str:
    """An interval in brackets, as ` (1.8 to 3.1)`; open ends are stated."""
    if estimate.lower is None:
        return " (too few seeds for an interval)"
    if estimate.upper is None:
        return f" (at least {figure(estimate.lower)})"
    return f" ({figure(estimate.lower)} to {figure(estimate.upper)})"


def names(of: Sequence[str]) -> str:
    """A list, as `a, b and c`, or `a, b, c and 4 others`."""
    if len(of) == 1:
        return of[0]
    shown, more = (of, 0) if len(of) <= MANY + 1 else (of[:MANY], len(of) - MANY)
    return f"{', '.join(shown)} and {more} others" if more else f"{', '.join(shown[:-1])} and {shown[-1]}"


def times_as(measure: Measure, ratio: IntervalEstimate) -> str:
    """A ratio of running times, as `needs 2.3 (1.8 to 3.1) times as many evaluations`."""
    number = f"{figure(ratio.value or 0.0)}{between(ratio)} times as"
    return f"needs {number} many evaluations" if measure == "evaluations" else f"takes {number} long"
