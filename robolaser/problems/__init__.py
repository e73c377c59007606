"""Questions for pymoo."""

from robolaser.problems.calibration import ReducedCalibration, ScannerCalibration
from robolaser.problems.complexity import Addition, BestAmplitudes, GapAgainstComplexity, Neighbourhood

__all__ = [
    "Addition",
    "BestAmplitudes",
    "GapAgainstComplexity",
    "Neighbourhood",
    "ReducedCalibration",
    "ScannerCalibration",
]
