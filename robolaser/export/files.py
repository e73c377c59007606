"""The files of a calibration for ROS, for simulators and for other programs."""

from collections.abc import Callable, Mapping
from importlib.util import find_spec
from typing import Final

from robolaser.calibration.checks import setup_limit_m
from robolaser.calibration.result import Calibration
from robolaser.export.controller_table import controller_table
from robolaser.export.mjcf import mjcf
from robolaser.export.python_module import corrected_module
from robolaser.export.ros import camera_yaml, easy_handeye2, static_transform
from robolaser.export.sdf import sdf
from robolaser.export.ur_calibration import ur_calibration
from robolaser.export.urdf import corrected_urdf, robot_urdf

EXPORTED: Final[Mapping[str, Callable[[Calibration], str | None]]] = {  # function that writes each; None: no file
    "robot.urdf": robot_urdf,
    "robot_corrected.urdf": corrected_urdf,
    "camera.yaml": camera_yaml,
    "static_transform.sh": static_transform,
    "easy_handeye2.calib": easy_handeye2,
    "robot_corrected.xml": mjcf,
    "robot_corrected.sdf": sdf,
    "corrected.py": corrected_module,
    "controller.csv": controller_table,
    "calibration.yaml": ur_calibration,
}


def missing_reader(file: str) -> str | None:
    """The extra that would read a file back, where it is not installed; None for the other files."""
    return "mujoco" if file == "robot_corrected.xml" and find_spec("mujoco") is None else None


def exported(calibration: Calibration) -> dict[str, str | None]:
    """The files of `EXPORTED` by name, for ROS and for simulators; only robot.urdf where `is_withheld`."""
    withheld = is_withheld(calibration)
    return {
        name: write(calibration) if name == "robot.urdf" or not withheld else None for name, write in EXPORTED.items()
    }


def is_withheld(calibration: Calibration) -> bool:
    """Whether errors show that the data set describes the cell wrongly: exported files would seem correct.

    Both fitted and new points must show it: gross errors, which a diagnosis excludes from the latter, do not.
    """
    new_m = calibration.held_out_rms_m
    return min(calibration.rms_m, calibration.rms_m if new_m is None else new_m) >= setup_limit_m(
        calibration.model.dataset
    )
