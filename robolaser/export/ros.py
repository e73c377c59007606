"""Camera and hand-eye for ROS: camera_info, commands that publish frames, and easy_handeye2's file."""

import json
import shlex

import numpy as np

from robolaser.arrays import Array
from robolaser.calibration.result import Calibration
from robolaser.export.urdf import placed_frames
from robolaser.geometry.rigid_motion import to_quaternion
from robolaser.model.sensors.camera import OPTICAL
from robolaser.model.sensors.in_cell import CameraView
from robolaser.model.stages import Stage

GRID = 41  # lines across the image, edges included, on which the distortion is converted


def static_transform(calibration: Calibration) -> str | None:
    """Command lines that publish the frames of the sensor and its target; None where it has none."""
    every = ((link, name, T) for link, frames in placed_frames(calibration).items() for name, T in frames.items())
    commands = [_command(link, name, T) for link, name, T in every if name in calibration.in_cell.published]
    return " &\n".join(commands) + "\n" if commands else None


def _command(link: str, name: str, T: Array) -> str:
    x, y, z, qx, qy, qz, qw = _numbers(T)
    return (
        f"ros2 run tf2_ros static_transform_publisher --x {x} --y {y} --z {z}"
        f" --qx {qx} --qy {qy} --qz {qz} --qw {qw}"
        f" --frame-id {shlex.quote(link)} --child-frame-id {shlex.quote(name)}"
    )


def easy_handeye2(calibration: Calibration) -> str | None:
    """easy_handeye2's file ~/.ros2/easy_handeye2/calibrations/NAME.calib; None where there is no camera."""
    placed = placed_frames(calibration)
    flange, base = placed
    carrier = flange if OPTICAL in placed[flange] else base
    if OPTICAL not in placed[carrier]:
        return None
    x, y, z, qx, qy, qz, qw = _numbers(placed[carrier][OPTICAL])
    lines = [
        "parameters:",
        f"  name: {_yaml(calibration.model.dataset.name)}",
        f"  calibration_type: {'eye_in_hand' if carrier == flange else 'eye_on_base'}",
        f"  robot_base_frame: {_yaml(base)}",
        f"  robot_effector_frame: {_yaml(flange)}",
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


def camera_yaml(calibration: Calibration) -> str | None:
    """The camera as ROS camera_info in YAML, for images in `scanner_camera_optical` or a camera's `camera_optical`.

    A camera's own parameters are plumb_bob's. A scanner's radial term maps distorted pixels to rays, plumb_bob's maps
    rays to distorted pixels: the coefficients agree best over the image, and a comment states the largest
    disagreement. A lens with focus breathing is as at the mean distance. None where the sensor has no camera or the
    image size is unknown.
    """
    model, dataset = calibration.model, calibration.model.dataset
    camera = calibration.in_cell.camera
    if camera is None or dataset.image_px is None:
        return None
    if camera.distortion is not None:
        distortion, remark = camera.distortion, "# plumb_bob is the calibrated camera's own model."
    else:
        lens = (one.effect for one in model.effects if one.effect.stage is Stage.IMAGE)
        bent = any(not effect.depends_on_trajectory for effect in lens)
        distortion, error_px = plumb_bob(camera, dataset.image_px, decentred=bent)
        remark = f"# plumb_bob agrees with the calibrated lens within {error_px:.2g} px over the image."
    K = camera.K
    width, height = dataset.image_px
    lines = [
        remark,
        f"image_width: {width}",
        f"image_height: {height}",
        f"camera_name: {_yaml(dataset.name)}",
        *_matrix("camera_matrix", K),
        "distortion_model: plumb_bob",
        *_matrix("distortion_coefficients", distortion[None]),
        *_matrix("rectification_matrix", np.eye(3)),
        *_matrix("projection_matrix", np.column_stack([K, np.zeros(3)])),
    ]
    return "\n".join(lines) + "\n"


def plumb_bob(camera: CameraView, image_px: tuple[int, int], *, decentred: bool) -> tuple[Array, float]:
    """OpenCV's (k1, k2, p1, p2, k3) of a camera with lens effects, and the largest disagreement over the image [px].

    p1 and p2 are zero unless it is decentred.
    """
    width, height = image_px
    across, down = np.meshgrid(np.linspace(-0.5, width - 0.5, GRID), np.linspace(-0.5, height - 0.5, GRID))
    pixel = np.stack([across.ravel(), down.ravel()], axis=-1)
    slopes = camera.slopes(pixel)
    x, y = slopes.T
    focal_px, centre = np.diag(camera.K)[:2], camera.K[:2, 2]
    moved = pixel - centre - focal_px * slopes
    r2 = x**2 + y**2
    columns = [np.stack([x * r2**n, y * r2**n], axis=-1) for n in (1, 2, 3)]
    if decentred:
        columns += [np.stack([2 * x * y, r2 + 2 * y**2], axis=-1), np.stack([r2 + 2 * x**2, 2 * x * y], axis=-1)]
    by_each = np.stack([focal_px * column for column in columns], axis=-1)
    A = by_each.reshape(-1, by_each.shape[-1])
    scale = np.linalg.norm(A, axis=0)
    coefficients = np.linalg.lstsq(A / scale, moved.ravel(), rcond=None)[0] / scale
    error = np.linalg.norm(moved - by_each @ coefficients, axis=-1).max()
    k1, k2, k3, p1, p2 = (*coefficients, 0.0, 0.0)[:5]
    return np.array([k1, k2, p1, p2, k3]), float(error)


def _matrix(name: str, matrix: Array) -> list[str]:
    rows, columns = matrix.shape
    data = ", ".join(f"{value:.12g}" for value in matrix.ravel())
    return [f"{name}:", f"  rows: {rows}", f"  cols: {columns}", f"  data: [{data}]"]


def _yaml(text: str) -> str:
    """Any name as text in YAML: on one line, between quotation marks."""
    line = "".join(letter if letter.isprintable() else " " for letter in text)
    return json.dumps(line, ensure_ascii=False)
