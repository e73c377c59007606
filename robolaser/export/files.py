"""The files of a calibration for ROS, for simulators and for programs of one's own."""

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

EXPORTED: Final = (
    "robot.urdf", "robot_corrected.urdf", "camera.yaml", "static_transform.sh", "easy_handeye2.calib",
    "robot_corrected.xml", "robot_corrected.sdf", "corrected.py", "controller.csv", "calibration.yaml",
)  # fmt: skip


def exported(calibration: Calibration) -> dict[str, str | None]:
    """The files of `EXPORTED` by name, for ROS and for simulators; None for one that this calibration does not have.

    Only `robot_urdf` where `is_withheld`.
    """
    of_sensor = (camera_yaml, static_transform, easy_handeye2)
    writers = (corrected_urdf, *of_sensor, mjcf, sdf, corrected_module, controller_table, ur_calibration)
    withheld = is_withheld(calibration)
    texts = [robot_urdf(calibration), *(None if withheld else write(calibration) for write in writers)]
    return dict(zip(EXPORTED, texts, strict=True))


def is_withheld(calibration: Calibration) -> bool:
    """Whether errors say that the data set describes the cell wrongly: what is exported would look as if it were good.

    Fitted points and new ones must both say so: gross errors, which a diagnosis leaves out of the latter, do not.
    """
    new_m = calibration.held_out_rms_m
    return min(calibration.rms_m, calibration.rms_m if new_m is None else new_m) >= setup_limit_m(
        calibration.model.dataset
    )
