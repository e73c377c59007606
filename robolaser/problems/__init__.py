"""Questions for pymoo."""

from robolaser.problems.calibration import ScannerCalibration
from robolaser.problems.reduction import ReducedCalibration
from robolaser.problems.suite import suite

__all__ = ["ReducedCalibration", "ScannerCalibration", "suite"]
