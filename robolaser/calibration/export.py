"""Export of a calibration: URDFs with the sensor at its calibrated place, and the camera for ROS."""

import json
from collections.abc import Mapping

import numpy as np

from robolaser.arrays import Array
from robolaser.calibration.result import Calibration
from robolaser.geometry import urdf
from robolaser.geometry.rigid_motion import exp_so3, pose
from robolaser.model.effects.effect import perturb_with
from robolaser.model.sensors.camera_view import CameraView
from robolaser.model.stages import Perturbation, Stage
from robolaser.parameters import Values

FLANGE_ONLY = '<?xml version="1.0"?>\n<robot name="flange">\n  <link name="flange"/>\n</robot>\n'
"""The robot of a data set with measured flange poses."""
BASE_ONLY = FLANGE_ONLY.replace('"flange"', '"base"')
"""The same where the sensor stands in the cell: what joins base and flange is not known."""
GRID = 41  # lines across the image, edges included, on which the distortion is converted


def robot_urdf(calibration: Calibration) -> str:
    """The data set's robot with the sensor at its calibrated place, as fixed frames on the flange.

    A stripe scanner becomes `scanner_camera` (the camera frame of the data set's conventions), `scanner_camera_optical`
    (ROS: z along the view, x along image u, y along image v) and `scanner_laser` (origin where the laser plane
    meets the camera's x axis, x its normal, z in the plane, as near to the view as possible). A camera becomes
    `camera_optical`, on the flange or on the base, and a target on the flange `target`. Reflectors and balls
    become `tool_<name>`, oriented like the flange. A name that is taken gets a number. A bracket or laser plane that
    drifts is placed as at the first pose.
    """
    robot = calibration.model.dataset.robot
    return _with_sensor(robot.urdf if robot else FLANGE_ONLY, calibration)


def corrected_urdf(calibration: Calibration) -> str | None:
    """As `robot_urdf`, with the joints' origins at their calibrated places.

    Offsets move a joint's zero: its limits then count from the new one. None where the model has no effect that a URDF
    can express.
    """
    model, robot = calibration.model, calibration.model.dataset.robot
    values = _values(calibration)
    written = tuple(
        candidate_effect.at(values) for candidate_effect in model.effects if candidate_effect.effect.in_urdf
    )
    if robot is None or not written:
        return None
    perturb = perturb_with(written, model.run)
    offset = perturb(Stage.JOINTS, np.zeros((1, 1, len(robot.joints))))[0, 0]
    along = robot.axes * offset[:, None]
    turn = np.where(robot.prismatic[:, None], 0.0, along)
    shift = np.where(robot.prismatic[:, None], along, 0.0)
    placements = perturb(Stage.LINKS, robot.placements[None, None])[0, 0] @ pose(exp_so3(turn), shift)
    return _with_sensor(robot.urdf_with(placements), calibration)


def camera_yaml(calibration: Calibration) -> str | None:
    """The camera as ROS camera_info in YAML, for images in `scanner_camera_optical` or a camera's `camera_optical`.

    A camera's own parameters are plumb_bob's. A scanner's radial term maps distorted pixels to rays, plumb_bob's maps
    rays to distorted pixels: the coefficients are those that agree best over the image, and a comment states the
    largest disagreement. None where the sensor has no camera or the image size is unknown.
    """
    dataset = calibration.model.dataset
    camera = calibration.model.sensor.camera(_values(calibration), _perturbation(calibration))
    if camera is None or dataset.image_px is None:
        return None
    if camera.distortion is not None:
        distortion, remark = camera.distortion, "# plumb_bob is the calibrated camera's own model."
    else:
        own = "tangential" in calibration.model.sensor.lens_terms(dataset)
        bent = any(candidate_effect.effect.stage is Stage.IMAGE for candidate_effect in calibration.model.effects)
        distortion, error_px = plumb_bob(camera, dataset.image_px, decentred=own or bent)
        remark = f"# plumb_bob agrees with the calibrated lens within {error_px:.2g} px over the image."
    K = camera.K
    width, height = dataset.image_px
    P = np.column_stack([K, np.zeros(3)])
    lines = [
        remark,
        f"image_width: {width}",
        f"image_height: {height}",
        f"camera_name: {json.dumps(_one_line(dataset.name), ensure_ascii=False)}",
        *_matrix("camera_matrix", K),
        "distortion_model: plumb_bob",
        *_matrix("distortion_coefficients", distortion[None]),
        *_matrix("rectification_matrix", np.eye(3)),
        *_matrix("projection_matrix", P),
    ]
    return "\n".join(lines) + "\n"


def plumb_bob(camera: CameraView, image_px: tuple[int, int], *, decentred: bool) -> tuple[Array, float]:
    """OpenCV's (k1, k2, p1, p2, k3) of a camera, and the largest disagreement over the image [px].

    Args:
        camera: With the lens effects, which are converted too.
        image_px: Width and height [px].
        decentred: Whether p1 and p2 may differ from zero.
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


def _values(calibration: Calibration) -> Values:
    return calibration.model.parameters.values(calibration.x[None])


def _perturbation(calibration: Calibration) -> Perturbation:
    return calibration.model.perturb(_values(calibration))


def _with_sensor(text: str, calibration: Calibration) -> str:
    robot = calibration.model.dataset.robot
    flange = robot.flange if robot else "flange"
    values, perturb = _values(calibration), _perturbation(calibration)
    sensor = calibration.model.sensor
    if robot is not None:
        base = urdf.parse(text).root
    elif sensor.base_frames(values, perturb):
        return _with_frames(BASE_ONLY, "base", sensor.base_frames(values, perturb))
    text = _with_frames(text, flange, sensor.flange_frames(values, perturb))
    return text if robot is None else _with_frames(text, base, sensor.base_frames(values, perturb))


def _with_frames(text: str, parent: str, frames: Mapping[str, Array]) -> str:
    for name, T_parent_frame in frames.items():
        text = _with_frame(text, parent, name, T_parent_frame)
    return text


def _with_frame(text: str, parent: str, name: str, T_parent_child: Array) -> str:
    taken, free, count = urdf.parse(text).links, name, 2
    while free in taken:
        free, count = f"{name}_{count}", count + 1
    return urdf.with_fixed_frame(text, parent, free, T_parent_child)


def _matrix(name: str, matrix: Array) -> list[str]:
    rows, columns = matrix.shape
    data = ", ".join(f"{value:.12g}" for value in matrix.ravel())
    return [f"{name}:", f"  rows: {rows}", f"  cols: {columns}", f"  data: [{data}]"]


def _one_line(text: str) -> str:
    return "".join(letter if letter.isprintable() else " " for letter in text)
