"""robolaser: calibrate robot-mounted sensors, and find out why the robot deviates from its model.

    dataset = robolaser.load("measured")               a folder with dataset.toml, poses.csv and points.csv
    robolaser.check(dataset)                           what it allows
    found = robolaser.calibrate(dataset)               parameters, their uncertainty, errors on new poses
    why = robolaser.diagnose(dataset)                  which effects cause the remaining errors
    found.save("result"); why.report("why.html")       as the commands of these names

Functions: load, save, import_files, extract, simulate, check, plan, calibrate, diagnose, compare, find_robot,
load_calibration, load_diagnosis, progress_bar. Point clouds: `robolaser.scan`. For pymoo: `robolaser.algorithms`,
`robolaser.operators`, `robolaser.problems`. Lengths are metres, angles radians.
"""

from importlib import import_module
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from robolaser import scan as scan
    from robolaser.api import calibrate, check, compare, diagnose, extract, import_files, load, plan
    from robolaser.calibration.plan import Plan
    from robolaser.data.dataset import Dataset
    from robolaser.data.importers.importer import ImportOptions
    from robolaser.data.importers.robots import find_robot
    from robolaser.data.writing import save
    from robolaser.errors import RobolaserError
    from robolaser.model.effects import EFFECTS
    from robolaser.report.progress_bar import progress_bar
    from robolaser.results.calibration import CalibrationResult, load_calibration
    from robolaser.results.comparison import ComparisonResult, load_comparison
    from robolaser.results.diagnosis import DiagnosisResult, load_diagnosis
    from robolaser.simulation.simulate import simulate

_HOME = {
    "CalibrationResult": "results.calibration",
    "ComparisonResult": "results.comparison",
    "Dataset": "data.dataset",
    "DiagnosisResult": "results.diagnosis",
    "EFFECTS": "model.effects",
    "ImportOptions": "data.importers.importer",
    "Plan": "calibration.plan",
    "RobolaserError": "errors",
    "calibrate": "api",
    "check": "api",
    "compare": "api",
    "diagnose": "api",
    "extract": "api",
    "find_robot": "data.importers.robots",
    "import_files": "api",
    "load": "api",
    "load_calibration": "results.calibration",
    "load_comparison": "results.comparison",
    "load_diagnosis": "results.diagnosis",
    "plan": "api",
    "progress_bar": "report.progress_bar",
    "save": "data.writing",
    "simulate": "simulation.simulate",
}

__all__ = [
    "EFFECTS",
    "CalibrationResult",
    "ComparisonResult",
    "Dataset",
    "DiagnosisResult",
    "ImportOptions",
    "Plan",
    "RobolaserError",
    "calibrate",
    "check",
    "compare",
    "diagnose",
    "extract",
    "find_robot",
    "import_files",
    "load",
    "load_calibration",
    "load_comparison",
    "load_diagnosis",
    "plan",
    "progress_bar",
    "save",
    "simulate",
]


def __getattr__(name: str) -> Any:
    """Load a name when it is first used: `robolaser --help` does not pay for physics."""
    if name == "__version__":
        from importlib.metadata import PackageNotFoundError, version  # noqa: PLC0415 - a fifth of `--help`

        try:
            return version("robolaser")
        except PackageNotFoundError:
            return "0+source"
    if name == "scan":
        return import_module("robolaser.scan")
    if name not in _HOME:
        raise AttributeError(f"module 'robolaser' has no attribute '{name}'")
    return getattr(import_module(f"robolaser.{_HOME[name]}"), name)


def __dir__() -> list[str]:
    """The public names."""
    return [*__all__, "scan", "__version__"]
