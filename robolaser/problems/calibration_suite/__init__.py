"""Calibrations with known optima, to compare optimisers on."""

from robolaser.problems.calibration_suite.problem import Suite, SuiteProblem, suite

__all__ = ["Suite", "SuiteProblem", "suite"]
