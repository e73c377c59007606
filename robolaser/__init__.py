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
    from robolaser.api import calibrate as calibrate
    from robolaser.api import check as check
    from robolaser.api import compare as compare
    from robolaser.api import diagnose as diagnose
    from robolaser.api import extract as extract
    from robolaser.api import import_files as import_files
    from robolaser.api import load as load
    from robolaser.api import plan as plan
    from robolaser.calibration.plan import Plan as Plan
    from robolaser.data.dataset import Dataset as Dataset
    from robolaser.data.importers.importer import ImportOptions as ImportOptions
    from robolaser.data.importers.robots import find_robot as find_robot
    from robolaser.data.writing import save as save
    from robolaser.errors import RobolaserError as RobolaserError
    from robolaser.model.effects import EFFECTS as EFFECTS
    from robolaser.report.progress_bar import progress_bar as progress_bar
    from robolaser.results.calibration import CalibrationResult as CalibrationResult
    from robolaser.results.calibration import load_calibration as load_calibration
    from robolaser.results.comparison import ComparisonResult as ComparisonResult
    from robolaser.results.comparison import load_comparison as load_comparison
    from robolaser.results.diagnosis import DiagnosisResult as DiagnosisResult
    from robolaser.results.diagnosis import load_diagnosis as load_diagnosis
    from robolaser.simulation.simulate import simulate as simulate

_HOME = {
    name: module
    for module, names in {
        "api": "calibrate check compare diagnose extract import_files load plan",
        "calibration.plan": "Plan",
        "data.dataset": "Dataset",
        "data.importers.importer": "ImportOptions",
        "data.importers.robots": "find_robot",
        "data.writing": "save",
        "errors": "RobolaserError",
        "model.effects": "EFFECTS",
        "report.progress_bar": "progress_bar",
        "results.calibration": "CalibrationResult load_calibration",
        "results.comparison": "ComparisonResult load_comparison",
        "results.diagnosis": "DiagnosisResult load_diagnosis",
        "simulation.simulate": "simulate",
    }.items()
    for name in names.split()
}
__all__ = list(_HOME)


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
