"""Questions for pymoo."""

from robolaser.problems.calibration import ScannerCalibration
from robolaser.problems.complexity import Addition, BestAmplitudes, GapAgainstComplexity, Neighbourhood
from robolaser.problems.reduction import ReducedCalibration

__all__ = [
    "Addition",
    "BestAmplitudes",
    "GapAgainstComplexity",
    "Neighbourhood",
    "ReducedCalibration",
    "ScannerCalibration",
]
