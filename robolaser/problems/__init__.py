"""Questions for pymoo."""

from robolaser.problems.calibration import ScannerCalibration
from robolaser.problems.calibration_suite import suite
from robolaser.problems.reduction import ReducedCalibration

__all__ = ["ReducedCalibration", "ScannerCalibration", "suite"]
