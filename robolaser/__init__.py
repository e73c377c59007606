"""robolaser: calibrate robot-mounted laser scanners, and say why the robot does not do what the model says."""

from importlib import import_module
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from robolaser.calibration import Calibration
    from robolaser.comparison.contest import Contest
    from robolaser.comparison.holding import compare
    from robolaser.dataset import Dataset
    from robolaser.diagnosis import diagnose
    from robolaser.effects import EFFECTS
    from robolaser.errors import RobolaserError
    from robolaser.fit import calibrate
    from robolaser.folder import load
    from robolaser.plan import Plan
    from robolaser.robots import find_robot
    from robolaser.saving import save

_HOME = {
    "Calibration": "calibration",
    "Contest": "comparison.contest",
    "Dataset": "dataset",
    "EFFECTS": "effects",
    "Plan": "plan",
    "RobolaserError": "errors",
    "calibrate": "fit",
    "compare": "comparison.holding",
    "diagnose": "diagnosis",
    "find_robot": "robots",
    "load": "folder",
    "save": "saving",
}

__all__ = [
    "EFFECTS",
    "Calibration",
    "Contest",
    "Dataset",
    "Plan",
    "RobolaserError",
    "calibrate",
    "compare",
    "diagnose",
    "find_robot",
    "load",
    "save",
]


def __getattr__(name: str) -> Any:
    """Load a name when it is first used: `robolaser --help` does not pay for physics."""
    if name not in _HOME:
        raise AttributeError(f"module 'robolaser' has no attribute '{name}'")
    return getattr(import_module(f"robolaser.{_HOME[name]}"), name)
