"""Student's t: a few lines instead of a library that takes a quarter of a second to load."""

import math

HALVINGS = 53
"""Of the interval that the angle lies in: it is exact to rounding then."""


def half_width(probability: float, freedoms: int) -> float:
    """The value that t of some whole number of degrees of freedom stays below, on either side, with a probability."""
    low, high = 0.0, 0.5 * math.pi
    for _ in range(HALVINGS):
        middle = 0.5 * (low + high)
        low, high = (middle, high) if _probability_within(middle, freedoms) < probability else (low, middle)
    return math.sqrt(freedoms) * math.tan(0.5 * (low + high))


def _probability_within(angle: float, freedoms: int) -> float:
    """That |t| is below √freedoms tan(angle) (Abramowitz and Stegun, 26.7.3 and 26.7.4)."""
    odd = freedoms % 2
    term, total = math.cos(angle) if odd else 1.0, 0.0
    for order in range(1 + odd, freedoms, 2):
        total += term
        term *= order / (order + 1.0) * math.cos(angle) ** 2
    total *= math.sin(angle)
    return 2.0 / math.pi * (angle + total) if odd else total
