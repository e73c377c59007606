"""Candidates that rounding has put outside the bounds, and the box of sides 1 that some algorithms search in."""

import numpy as np

from robolaser.arrays import Array
from robolaser.benchmark.problem import Question

ROUNDING = 1e-12
"""Of the bounds' distance: what lies outside by no more was meant to lie on the bound."""


def within(x: Array, question: Question) -> Array:
    """Candidates (c, d), those meant to lie on a bound put there; the others stay where they are, be it outside."""
    inside = np.clip(x, question.lower, question.upper)
    return np.where(np.abs(x - inside) <= ROUNDING * (question.upper - question.lower), inside, x)


def from_unit_box(y: Array, question: Question) -> Array:
    """Candidates (c, d) of the box from 0 to 1 as those of the question."""
    return within(question.lower + y * (question.upper - question.lower), question)
