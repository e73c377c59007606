"""The hand-eye for ROS 2: a command that publishes it, and easy_handeye2's file."""

import json

from robolaser.arrays import Array
from robolaser.calibration.result import Calibration
from robolaser.geometry import urdf
from robolaser.geometry.rigid_motion import to_quaternion

OPTICAL = "camera_optical"


def static_transform(calibration: Calibration) -> str | None:
    """The command line that publishes where the camera sits; None where the sensor is no camera of its own."""
    placed = _placed(calibration)
    if placed is None:
        return None
    parent, T = placed
    x, y, z, qx, qy, qz, qw = _numbers(T)
    return (
        f"ros2 run tf2_ros static_transform_publisher --x {x} --y {y} --z {z}"
        f" --qx {qx} --qy {qy} --qz {qz} --qw {qw} --frame-id {parent} --child-frame-id {OPTICAL}\n"
    )


def easy_handeye2(calibration: Calibration) -> str | None:
    """What easy_handeye2 reads from ~/.ros2/easy_handeye2/calibrations/NAME.calib; None where there is no camera."""
    placed = _placed(calibration)
    if placed is None:
        return None
    base, flange = _links(calibration)
    x, y, z, qx, qy, qz, qw = _numbers(placed[1])
    lines = [
        "parameters:",
        f"  name: {json.dumps(calibration.model.dataset.name)}",
        f"  calibration_type: {'eye_in_hand' if placed[0] == flange else 'eye_on_base'}",
        f"  robot_base_frame: {base}",
        f"  robot_effector_frame: {flange}",
        f"  tracking_base_frame: {OPTICAL}",
        "  tracking_marker_frame: target",
        "  freehand_robot_movement: true",
        "transform:",
        f"  translation: {{x: {x}, y: {y}, z: {z}}}",
        f"  rotation: {{x: {qx}, y: {qy}, z: {qz}, w: {qw}}}",
    ]
    return "\n".join(lines) + "\n"


def _placed(calibration: Calibration) -> tuple[str, Array] | None:
    """The link that carries the camera, and T_link_camera."""
    model = calibration.model
    values = model.parameters.values(calibration.x[None])
    perturb = model.perturb(values)
    base, flange = _links(calibration)
    for link, frames in (
        (flange, model.sensor.flange_frames(values, perturb)),
        (base, model.sensor.base_frames(values, perturb)),
    ):
        if OPTICAL in frames:
            return link, frames[OPTICAL]
    return None


def _links(calibration: Calibration) -> tuple[str, str]:
    """Names of the base and the flange."""
    robot = calibration.model.dataset.robot
    return ("base", "flange") if robot is None else (urdf.parse(robot.urdf).root, robot.flange)


def _numbers(T: Array) -> list[str]:
    """Position [m] and quaternion (x, y, z, w), to a nanometre and less than a nanoradian."""
    return [f"{value:.9f}" for value in (*T[:3, 3], *to_quaternion(T[:3, :3]))]
