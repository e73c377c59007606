"""robolaser: calibrate robot-mounted laser scanners, and say why the robot does not do what the model says."""

from importlib import import_module
from typing import TYPE_CHECKING, Any

from robolaser.results import Looks, Result

if TYPE_CHECKING:
    from robolaser.benchmark.compare import compare
    from robolaser.calibration.calibrate import calibrate
    from robolaser.calibration.plan import Plan
    from robolaser.calibration.result import Calibration
    from robolaser.data.dataset import Dataset
    from robolaser.data.importers.robots import find_robot
    from robolaser.data.loading import load
    from robolaser.data.saved_result import load_calibration, load_diagnosis
    from robolaser.data.writing import save
    from robolaser.diagnosis import diagnose
    from robolaser.errors import RobolaserError
    from robolaser.model.effects import EFFECTS
    from robolaser.report.progress_bar import progress_bar

_HOME = {
    "Calibration": "calibration.result",
    "Dataset": "data.dataset",
    "EFFECTS": "model.effects",
    "Plan": "calibration.plan",
    "RobolaserError": "errors",
    "calibrate": "calibration.calibrate",
    "compare": "benchmark.compare",
    "diagnose": "diagnosis",
    "find_robot": "data.importers.robots",
    "load": "data.loading",
    "load_calibration": "data.saved_result",
    "load_diagnosis": "data.saved_result",
    "progress_bar": "report.progress_bar",
    "save": "data.writing",
}

__all__ = [
    "EFFECTS",
    "Calibration",
    "Dataset",
    "Plan",
    "RobolaserError",
    "calibrate",
    "compare",
    "diagnose",
    "find_robot",
    "load",
    "load_calibration",
    "load_diagnosis",
    "progress_bar",
    "save",
]


def __getattr__(name: str) -> Any:
    """Load a name when it is first used: `robolaser --help` does not pay for physics."""
    if name not in _HOME:
        raise AttributeError(f"module 'robolaser' has no attribute '{name}'")
    return getattr(import_module(f"robolaser.{_HOME[name]}"), name)


def _looks() -> Looks:
    from robolaser.report import results  # noqa: PLC0415 - makers of results do not pay for pages

    return results


Result.looks = _looks
