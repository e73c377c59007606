"""The hand-eye for ROS 2: commands that publish it, and easy_handeye2's file."""

import json
from collections.abc import Mapping, Sequence

from robolaser.arrays import Array
from robolaser.calibration.checks import SETUP_RMS_M
from robolaser.calibration.export import camera_yaml, corrected_urdf, robot_urdf
from robolaser.calibration.result import Calibration
from robolaser.calibration.simulators.mjcf import mjcf
from robolaser.calibration.simulators.python_module import corrected_module
from robolaser.calibration.simulators.sdf import sdf
from robolaser.geometry import urdf
from robolaser.geometry.rigid_motion import to_quaternion
from robolaser.model.sensors.camera import OPTICAL
from robolaser.results import EXPORTED


def exported(calibration: Calibration) -> dict[str, str | None]:
    """The files of `EXPORTED` by name, for ROS and for simulators; None for one that this calibration does not have.

    Only `robot_urdf` where `is_withheld`.
    """
    writers = (corrected_urdf, camera_yaml, static_transform, easy_handeye2, mjcf, sdf, corrected_module)
    withheld = is_withheld(calibration)
    texts = [robot_urdf(calibration), *(None if withheld else write(calibration) for write in writers)]
    return dict(zip(EXPORTED, texts, strict=True))


def is_withheld(calibration: Calibration) -> bool:
    """Whether errors say that the data set describes the cell wrongly: what is exported would look as if it were good.

    Fitted points and new ones must both say so: gross errors, which a diagnosis leaves out of the latter, do not.
    """
    new_m = calibration.held_out_rms_m
    return min(calibration.rms_m, calibration.rms_m if new_m is None else new_m) >= SETUP_RMS_M


def static_transform(calibration: Calibration) -> str | None:
    """Command lines that publish where the sensor sits, and what it tracks; None where it has no frames for that."""
    published = calibration.model.sensor.published_frames
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
    model = calibration.model
    values = model.parameters.values(calibration.x[None])
    perturb = model.perturb(values)
    base, flange = _links(calibration)
    return [(flange, model.sensor.flange_frames(values, perturb)), (base, model.sensor.base_frames(values, perturb))]


def _links(calibration: Calibration) -> tuple[str, str]:
    """Names of the base and the flange."""
    robot = calibration.model.dataset.robot
    return ("base", "flange") if robot is None else (urdf.parse(robot.urdf).root, robot.flange)


def _numbers(T: Array) -> list[str]:
    """Position [m] and quaternion (x, y, z, w), to a nanometre and less than a nanoradian."""
    return [f"{value:.9f}" for value in (*T[:3, 3], *to_quaternion(T[:3, :3]))]
