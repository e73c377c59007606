"""The hand-eye for ROS 2: commands that publish it, and easy_handeye2's file."""

import json

from robolaser.arrays import Array
from robolaser.calibration.result import Calibration
from robolaser.export.urdf import placed_frames
from robolaser.geometry.rigid_motion import to_quaternion
from robolaser.model.blocks.cell_frames import published_frames
from robolaser.model.sensors.camera import OPTICAL


def static_transform(calibration: Calibration) -> str | None:
    """Command lines that publish where the sensor sits, and what it tracks; None where it has no frames for that."""
    published = published_frames(*calibration.solved)
    every = ((link, name, T) for link, frames in placed_frames(calibration).items() for name, T in frames.items())
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
    placed = placed_frames(calibration)
    flange, base = placed
    carrier = flange if OPTICAL in placed[flange] else base
    if OPTICAL not in placed[carrier]:
        return None
    x, y, z, qx, qy, qz, qw = _numbers(placed[carrier][OPTICAL])
    lines = [
        "parameters:",
        f"  name: {json.dumps(calibration.model.dataset.name)}",
        f"  calibration_type: {'eye_in_hand' if carrier == flange else 'eye_on_base'}",
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


def _numbers(T: Array) -> list[str]:
    """Position [m] and quaternion (x, y, z, w), to a nanometre and less than a nanoradian."""
    return [f"{value:.9f}" for value in (*T[:3, 3], *to_quaternion(T[:3, :3]))]
