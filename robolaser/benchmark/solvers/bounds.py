"""Bounds: candidates that rounding has put outside them, and the unit box in which some algorithms search."""

import numpy as np

from robolaser.arrays import Array
from robolaser.benchmark.problem import BenchmarkProblem

ROUNDING = 1e-12
"""Share of the distance between the bounds: a candidate outside by no more was meant to lie on the bound."""


def within(x: Array, problem: BenchmarkProblem) -> Array:
    """Candidates (c, d) with those meant to lie on a bound moved onto it; the others stay, even outside."""
    inside = np.clip(x, problem.lower, problem.upper)
    return np.where(np.abs(x - inside) <= ROUNDING * (problem.upper - problem.lower), inside, x)


def from_unit_box(y: Array, problem: BenchmarkProblem) -> Array:
    """Map candidates (c, d) from the unit box to the problem's bounds."""
    return within(problem.lower + y * (problem.upper - problem.lower), problem)


def to_unit_box(x: Array, problem: BenchmarkProblem) -> Array:
    """Map candidates (c, d) within the problem's bounds to the unit box."""
    width = problem.upper - problem.lower
    return (x - problem.lower) / np.where(width > 0, width, 1.0)
