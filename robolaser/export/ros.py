"""The hand-eye for ROS 2: commands that publish it, and easy_handeye2's file."""

import json
from collections.abc import Mapping, Sequence

from robolaser.arrays import Array
from robolaser.calibration.result import Calibration
from robolaser.geometry.rigid_motion import to_quaternion
from robolaser.model.blocks.blocks import Blocks
from robolaser.model.blocks.cell_frames import base_frames, flange_frames, published_frames
from robolaser.model.sensors.camera import OPTICAL
from robolaser.model.stages import Perturbation
from robolaser.parameters import Values


def static_transform(calibration: Calibration) -> str | None:
    """Command lines that publish where the sensor sits, and what it tracks; None where it has no frames for that."""
    published = published_frames(*_at(calibration))
    every = ((link, name, T) for link, frames in _frames(calibration) for name, T in frames.items())
    commands = [_command(link, name, T) for link, name, T in every if name in published]
    return " &\n".join(commands) + "\n" if commands else None


def _command(link: str, name: str, T: Array) -> str:
    x, y, z, qx, qy, qz, qw = _numbers(T)
    return (
        f"ros2 run tf2_ros static_transform_publisher --x {x} --y {y} --z {z}"
        f" --qx {qx} --qy {qy} --qz {qz} --qw {qw} --frame-id {link} --child-frame-id {name}"
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
    return next(((link, frames[OPTICAL]) for link, frames in _frames(calibration) if OPTICAL in frames), None)


def _frames(calibration: Calibration) -> Sequence[tuple[str, Mapping[str, Array]]]:
    """The sensor's frames on the flange and on the base, each with the link's name."""
    at, (base, flange) = _at(calibration), _links(calibration)
    return [(flange, flange_frames(*at)), (base, base_frames(*at))]


def _at(calibration: Calibration) -> tuple[Blocks, Values, Perturbation]:
    """The sensors with what was found."""
    values = calibration.model.parameters.values(calibration.x[None])
    return calibration.model.blocks, values, calibration.model.perturb(values)


def _links(calibration: Calibration) -> tuple[str, str]:
    """Names of the base and the flange."""
    robot = calibration.model.dataset.robot
    return ("base", "flange") if robot is None else (robot.base, robot.flange)


def _numbers(T: Array) -> list[str]:
    """Position [m] and quaternion (x, y, z, w), to a nanometre and less than a nanoradian."""
    return [f"{value:.9f}" for value in (*T[:3, 3], *to_quaternion(T[:3, :3]))]
