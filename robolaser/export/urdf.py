"""URDFs with the sensor at its calibrated pose."""

from collections.abc import Mapping

from robolaser.arrays import Array
from robolaser.calibration.result import Calibration
from robolaser.robot.urdf.editing import with_fixed_frames

FLANGE_ONLY = '<?xml version="1.0"?>\n<robot name="flange">\n  <link name="flange"/>\n</robot>\n'
"""The robot of a data set with measured flange poses."""
BASE_ONLY = FLANGE_ONLY.replace('"flange"', '"base"')
"""The same with the sensor in the cell: the arm between base and flange is unknown."""


def robot_urdf(calibration: Calibration) -> str:
    """The data set's robot with the sensor at its calibrated pose, as fixed frames on the flange.

    A stripe scanner becomes `scanner_camera` (the camera frame of the data set's conventions), `scanner_camera_optical`
    (ROS: z along the view, x along image u, y along image v) and `scanner_laser` (origin where the laser plane
    meets the camera's x axis, x its normal, z in the plane, as near to the view as possible). A camera becomes
    `camera_optical`, on the flange or on the base, and a target on the flange `target`. Reflectors and balls
    become `tool_<name>`, oriented like the flange. A name that is taken gets a number. A bracket or laser plane that
    drifts is placed as at the first pose.
    """
    robot = calibration.model.dataset.robot
    if robot is not None:
        return _with_sensor(robot.urdf, calibration)
    (flange, carried), (base, standing) = placed_frames(calibration).items()
    if standing:
        return with_fixed_frames(BASE_ONLY, base, standing)
    return with_fixed_frames(FLANGE_ONLY, flange, carried)


def corrected_urdf(calibration: Calibration) -> str | None:
    """As `robot_urdf`, with the joints' calibrated origins.

    None where the model has no effect that a URDF can represent.
    """
    if calibration.robot is calibration.model.dataset.robot or calibration.robot is None:
        return None
    return _with_sensor(calibration.robot.urdf, calibration)


def placed_frames(calibration: Calibration) -> Mapping[str, Mapping[str, Array]]:
    """The sensor's frames by the link that they are fixed to: the flange, then the base."""
    robot = calibration.model.dataset.robot
    base, flange = ("base", "flange") if robot is None else (robot.base, robot.flange)
    return {flange: calibration.in_cell.flange, base: calibration.in_cell.base}


def _with_sensor(text: str, calibration: Calibration) -> str:
    for link, frames in placed_frames(calibration).items():
        text = with_fixed_frames(text, link, frames) if frames else text
    return text
