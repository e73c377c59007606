"""A calibration for other programs: URDFs that carry the sensor where it was found, and the camera for ROS."""

import json
from collections.abc import Iterable, Iterator

import numpy as np

from robolaser.arrays import Array
from robolaser.calibration.result import Calibration
from robolaser.errors import NoCamera
from robolaser.geometry import camera as optics
from robolaser.geometry import urdf
from robolaser.geometry.rigid_motion import exp_so3, pose
from robolaser.model.effects.effect import perturb_with
from robolaser.model.sensors.stripe import Stripe
from robolaser.model.stages import Perturbation, Stage
from robolaser.parameters import Values

FLANGE_ONLY = '<?xml version="1.0"?>\n<robot name="flange">\n  <link name="flange"/>\n</robot>\n'
"""The robot of a data set with measured flange poses."""
GRID = 41  # lines across the image, edges included, on which the distortion is converted


def robot_urdf(calibration: Calibration) -> str:
    """The data set's robot with the sensor where the calibration found it, as fixed frames on the flange.

    A stripe scanner becomes `scanner_camera` (the camera frame of the data set's conventions), `scanner_camera_optical`
    (ROS: z along the view, x along image u, y along image v) and `scanner_laser` (origin where the sheet meets the
    camera's x axis, x the sheet's normal, z in the sheet, as near to the view as it can be). Reflectors and balls
    become `tool_<name>`, turned like the flange. A name that is taken gets a number. A bracket or sheet that an
    effect lets drift is placed as at the first pose.
    """
    robot = calibration.model.dataset.robot
    return _with_sensor(robot.urdf if robot else FLANGE_ONLY, calibration)


def corrected_urdf(calibration: Calibration) -> str | None:
    """As `robot_urdf`, with the joints' origins moved to where the calibration found them.

    Offsets turn a joint's zero: its limits then count from the new one. None where the model has no
    effect that a URDF can hold.
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


def camera_yaml(calibration: Calibration) -> str:
    """The camera as ROS camera_info in YAML, for images as the frame `scanner_camera_optical` sees them.

    Our radial term makes straight rays of distorted pixels, plumb_bob's makes distorted pixels of straight rays: the
    coefficients are those that agree best over the image, and a comment says how well.

    Raises:
        NoCamera: The sensor is no stripe scanner.
    """
    dataset = calibration.model.dataset
    if not isinstance(calibration.model.sensor, Stripe) or dataset.image_px is None:
        raise NoCamera(dataset.kind)
    K, distortion, error_px = plumb_bob(calibration)
    width, height = dataset.image_px
    P = np.column_stack([K, np.zeros(3)])
    lines = [
        f"# plumb_bob agrees with the calibrated lens within {error_px:.2g} px over the image.",
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


def plumb_bob(calibration: Calibration) -> tuple[Array, Array, float]:
    """The camera as OpenCV's: K (3, 3) [px], (k1, k2, p1, p2, k3), and the largest disagreement over the image [px].

    Effects of the lens in the model are converted too; p1 and p2 are zero without any. What biases the stripe's middle
    is no matter of the lens.
    """
    values, perturb = _values(calibration), _bend(calibration)
    width, height = calibration.model.dataset.image_px or (1, 1)
    f, s_u, s_v, u_0, v_0 = (float(values[name][0]) for name in ("f", "s_u", "s_v", "u_0", "v_0"))
    across, down = np.meshgrid(np.linspace(-0.5, width - 0.5, GRID), np.linspace(-0.5, height - 0.5, GRID))
    pixel = np.stack([across.ravel(), down.ravel()], axis=-1)
    distorted = optics.metric(pixel[None], values)
    x, y = (perturb(Stage.IMAGE, optics.undistort(distorted, values["k"]))[0] / f).T
    focal_px = np.array([f / s_u, f / s_v])
    moved = pixel - np.array([u_0, v_0]) - focal_px * np.stack([x, y], axis=-1)
    r2 = x**2 + y**2
    radial = [np.stack([x * r2**n, y * r2**n], axis=-1) for n in (1, 2, 3)]
    decentred = [np.stack([2 * x * y, r2 + 2 * y**2], axis=-1), np.stack([r2 + 2 * x**2, 2 * x * y], axis=-1)]
    bent = any(candidate_effect.effect.stage is Stage.IMAGE for candidate_effect in calibration.model.effects)
    columns = np.stack([focal_px * column for column in (radial + decentred if bent else radial)], axis=-1)
    A = columns.reshape(-1, columns.shape[-1])
    scale = np.linalg.norm(A, axis=0)
    found = np.linalg.lstsq(A / scale, moved.ravel(), rcond=None)[0] / scale
    error = np.linalg.norm(moved - columns @ found, axis=-1).max()
    k1, k2, k3, p1, p2 = (*found, 0.0, 0.0)[:5]
    K = np.array([[focal_px[0], 0.0, u_0], [0.0, focal_px[1], v_0], [0.0, 0.0, 1.0]])
    return K, np.array([k1, k2, p1, p2, k3]), float(error)


def _values(calibration: Calibration) -> Values:
    return calibration.model.parameters.values(calibration.x[None])


def _bend(calibration: Calibration) -> Perturbation:
    return calibration.model.perturb(_values(calibration))


def _with_sensor(text: str, calibration: Calibration) -> str:
    robot = calibration.model.dataset.robot
    flange = robot.flange if robot else "flange"
    for name, T_flange_frame in _frames(calibration):
        text = _with_frame(text, flange, name, T_flange_frame)
    return text


def _with_frame(text: str, parent: str, name: str, T_parent_child: Array) -> str:
    taken, free, count = urdf.parse(text).links, name, 2
    while free in taken:
        free, count = f"{name}_{count}", count + 1
    return urdf.with_fixed_frame(text, parent, free, T_parent_child)


def _frames(calibration: Calibration) -> Iterator[tuple[str, Array]]:
    """Names of frames and T_flange_frame of each."""
    sensor, values, perturb = calibration.model.sensor, _values(calibration), _bend(calibration)
    if not isinstance(sensor, Stripe):
        for tool in _tools(values):
            place = np.array([values[f"{tool}.{part}"][0] for part in "xyz"])
            yield tool.replace(".", "_", 1), pose(np.eye(3), place)
        return
    T_flange_camera = sensor.mount(values, perturb)[0, 0]
    yield "scanner_camera", T_flange_camera
    yield "scanner_camera_optical", T_flange_camera @ _optical(calibration.model.dataset.stripe_axis)
    yield "scanner_laser", T_flange_camera @ _laser(perturb(Stage.SHEET, optics.sheet(values))[0, 0])


def _tools(names: Iterable[str]) -> list[str]:
    return list(dict.fromkeys(name.rpartition(".")[0] for name in names if name.startswith("tool.")))


def _optical(stripe_axis: str) -> Array:
    """T_camera_optical: where the stripe runs along u, the camera's x is image v, its y against u; else no turn."""
    R = np.array([[0.0, 1.0, 0.0], [-1.0, 0.0, 0.0], [0.0, 0.0, 1.0]]) if stripe_axis == "u" else np.eye(3)
    return pose(R, np.zeros(3))


def _laser(plane: Array) -> Array:
    """T_camera_laser of the plane (n, d): see `robot_urdf`."""
    length = np.linalg.norm(plane[:3])
    normal, d = plane[:3] / length, plane[3] / length
    view = np.array([0.0, 0.0, 1.0])
    z = view - (view @ normal) * normal
    z /= np.linalg.norm(z)
    R = np.column_stack([normal, np.cross(z, normal), z])
    return pose(R, np.array([d / normal[0], 0.0, 0.0]))


def _matrix(name: str, matrix: Array) -> list[str]:
    rows, columns = matrix.shape
    data = ", ".join(f"{value:.12g}" for value in matrix.ravel())
    return [f"{name}:", f"  rows: {rows}", f"  cols: {columns}", f"  data: [{data}]"]


def _one_line(text: str) -> str:
    return "".join(letter if letter.isprintable() else " " for letter in text)
