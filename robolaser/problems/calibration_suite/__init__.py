"""Calibrations with known optima, to compare optimisers on."""

from robolaser.problems.calibration_suite.problem import SuiteProblem
from robolaser.problems.calibration_suite.table import Suite, suite

__all__ = ["Suite", "SuiteProblem", "suite"]
