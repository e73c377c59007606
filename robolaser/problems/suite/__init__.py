"""Calibrations with known optima, to compare optimisers on."""

from robolaser.problems.suite.problem import SuiteProblem
from robolaser.problems.suite.table import Suite, suite

__all__ = ["Suite", "SuiteProblem", "suite"]
