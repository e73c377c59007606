"""Questions for pymoo."""

from robolaser.problems.calibration import ReducedCalibration, ScannerCalibration

__all__ = ["ReducedCalibration", "ScannerCalibration"]
