"""Problems for pymoo."""

from robolaser.problems.calibration import ReducedCalibration, ScannerCalibration
from robolaser.problems.calibration_suite import suite

__all__ = ["ReducedCalibration", "ScannerCalibration", "suite"]
