"""The distribution of chi-squared: a few lines instead of a library that takes a quarter of a second to load."""

import math

HALVINGS = 60
"""Of the interval that the median lies in: it is exact to rounding after 53."""
NEGLIGIBLE = 1e-17
"""Share of a sum below which a term of it is left out."""


def survival(value: float, freedoms: int) -> float:
    """Probability that chi-squared of some whole number of degrees of freedom exceeds a value.

    By recurrence from one or two degrees of freedom (Abramowitz and Stegun, 26.4.4 and 26.4.5).
    """
    half = 0.5 * max(value, 0.0)
    odd = freedoms % 2
    total = math.erfc(math.sqrt(half)) if odd else 0.0
    term = math.exp(-half) * (math.sqrt(half) / math.gamma(1.5) if odd else 1.0)
    order = 0.5 if odd else 0.0
    for _ in range(freedoms // 2):
        total += term
        order += 1.0
        term *= half / order
    return total


def median(freedoms: float) -> float:
    """The value that chi-squared of some degrees of freedom, not necessarily whole, exceeds half the time."""
    low, high = 0.0, freedoms  # the median is below the mean
    for _ in range(HALVINGS):
        middle = 0.5 * (low + high)
        low, high = (middle, high) if _probability_below(middle, freedoms) < 0.5 else (low, middle)
    return 0.5 * (low + high)


def _probability_below(value: float, freedoms: float) -> float:
    """The regularised lower incomplete gamma function, by its series (Abramowitz and Stegun, 6.5.29)."""
    shape, half = 0.5 * freedoms, 0.5 * value
    if half <= 0.0:
        return 0.0
    term = math.exp(shape * math.log(half) - half - math.lgamma(shape + 1.0))
    total, order = term, shape
    while term > NEGLIGIBLE * total:
        order += 1.0
        term *= half / order
        total += term
    return total
