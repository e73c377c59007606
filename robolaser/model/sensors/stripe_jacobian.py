"""How a stripe's points move with the scanner's parameters: derivatives of eqs. 1-13 of Lee et al. 2004.

Rows stand along the last axis until the end: NumPy is several times as fast on long axes as on axes of three.
"""

import numpy as np

from robolaser.arrays import Array
from robolaser.data.dataset import Dataset
from robolaser.geometry.rigid_motion import angle_axes, common_length, from_angles, from_quaternion, skew
from robolaser.model.sensors.placements import motion
from robolaser.model.stages import Perturbation, Stage
from robolaser.parameters import Values

MOUNTED = 11
"""Parameters that move the point in the camera frame or turn it about the flange; after them come the shifts."""


def stripe_jacobian(dataset: Dataset, values: Values, T_base_flange: Array, perturb: Perturbation) -> Array:
    """Derivatives of known less predicted points in the base frame.

    Args:
        dataset: Pixels, target points, and how the scanner is built.
        values: All parameters, (c,) each.
        T_base_flange: (c or 1, n, 4, 4).
        perturb: Effects; none of them at mount, image, laser plane or light.

    Returns:
        By f, s_u, s_v, u_0, v_0, k, b, theta, w, phi, psi, t_x, t_y, t_z [m per unit], and where the target is not
        placed by its six, (c, m, 3, 14 or 20); a view of an array (c, 14 or 20, m, 3).
    """
    points = dataset.points
    angles = tuple(values[name] for name in ("w", "phi", "psi"))
    bracket = from_quaternion(np.array(dataset.bracket_quat))
    R_flange_camera = bracket @ from_angles(*angles, order=dataset.angles)
    axes = angle_axes(*angles, order=dataset.angles) @ bracket.T @ R_flange_camera
    in_camera = _in_camera(perturb(Stage.PIXELS, points["pixel"][None]), values, dataset.stripe_axis, axes)
    R_base_flange = T_base_flange[:, :, :3, :3]
    R_base_camera = R_base_flange @ R_flange_camera[:, None]

    known = perturb(Stage.TARGET, points["xyz"][None])
    c, m = common_length(in_camera[0], R_base_camera, known), len(points)
    J = np.empty((c, 14 if dataset.placed else 20, m, 3))
    turn = np.ascontiguousarray(np.moveaxis(R_base_camera, 1, -1))[..., points.pose]  # (c, 3, 3, m)
    part = np.empty((c, MOUNTED, m))
    for axis in range(3):
        total = -turn[:, axis, 0, None] * in_camera[0]
        for other in (1, 2):
            total -= np.multiply(turn[:, axis, other, None], in_camera[other], out=part)
        J[:, :MOUNTED, :, axis] = total
    J[:, MOUNTED:14] = -np.moveaxis(R_base_flange, -1, 1)[:, :, points.pose]
    if not dataset.placed:
        T = motion(values, "target")
        lever = known @ np.swapaxes(T[:, :3, :3], -1, -2)
        J[:, 14:17] = np.eye(3)[:, None]
        by_target = angle_axes(*(values[f"target.{name}"] for name in ("w", "phi", "psi")))
        J[:, 17:] = lever[:, None] @ np.swapaxes(skew(by_target), -1, -2)
    return np.moveaxis(J, 1, -1)


def _in_camera(pixel: Array, values: Values, stripe_axis: str, axes: Array) -> tuple[Array, Array, Array]:
    """Derivatives of points in the camera frame, along its three axes, (c, 11, m) each.

    Args:
        pixel: (c or 1, m, 2) [px].
        values: (c,) each.
        stripe_axis: "u" puts x along image v and y against image u, "v" x along u and y along v.
        axes: What the points turn about as each of the three angles grows, in the camera frame, (c, 3, 3).

    Returns:
        By f, s_u, s_v, u_0, v_0, k, b, theta and the three angles.
    """
    f, k, b, theta = (values[name][:, None] for name in ("f", "k", "b", "theta"))
    along = {"u": 0, "v": 1}
    first, second, sign = ("v", "u", -1.0) if stripe_axis == "u" else ("u", "v", 1.0)
    away = [pixel[..., along[name]] - values[f"{name}_0"][:, None] for name in (first, second)]
    pitch = [way * values[f"s_{name}"][:, None] for name, way in ((first, 1.0), (second, sign))]
    u, v = away[0] * pitch[0], away[1] * pitch[1]  # still distorted
    r2 = u * u + v * v
    grown = 1.0 + k * r2
    x, y = u * grown, v * grown
    cos, sin = np.cos(theta), np.sin(theta)
    facing = cos * x + sin * f
    with np.errstate(divide="ignore", invalid="ignore"):
        depth = b * cos / facing
        by_x, by_z, by_b = -cos / facing, -sin / facing, cos / facing
        by_theta = -(b * sin + depth * (cos * f - sin * x)) / facing
    point = x * depth, y * depth, f * depth

    c, m = common_length(x, cos), x.shape[1]
    along_x, along_y, along_z = np.zeros((3, c, MOUNTED, m))
    across = 2.0 * k * u * v
    columns = {"u": (1, 3), "v": (2, 4)}  # of pitch and origin
    for at, name, image in (
        (0, first, (grown + 2.0 * k * u * u, across)),
        (1, second, (across, grown + 2.0 * k * v * v)),
    ):
        by_pitch = away[at] * (1.0 if at == 0 else sign)
        for column, by in zip(columns[name], (by_pitch, -pitch[at]), strict=True):
            along_x[:, column], along_y[:, column] = image[0] * by, image[1] * by
    along_x[:, 5], along_y[:, 5] = u * r2, v * r2
    log_length = along_x[:, 1:6] * by_x[:, None]  # of the ray
    along_x[:, 1:6] *= depth[:, None]
    along_y[:, 1:6] *= depth[:, None]
    for moves, component, ray in zip((along_x, along_y, along_z), point, (x, y, f), strict=True):
        moves[:, 1:6] += component[:, None] * log_length
        moves[:, 0] = component * by_z
        moves[:, 6] = ray * by_b
        moves[:, 7] = ray * by_theta
    along_z[:, 0] += depth
    for moves, one, other in ((along_x, 1, 2), (along_y, 2, 0), (along_z, 0, 1)):
        moves[:, 8:] = axes[:, :, one, None] * point[other][:, None] - axes[:, :, other, None] * point[one][:, None]
    return along_x, along_y, along_z
