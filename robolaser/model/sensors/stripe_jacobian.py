"""How a stripe's points move with the scanner's parameters: derivatives of eqs. 1-13 of Lee et al. 2004."""

import numpy as np

from robolaser.arrays import Array
from robolaser.data.dataset import Dataset
from robolaser.geometry.camera import metric, rays, undistort
from robolaser.geometry.rigid_motion import angle_axes, common_length, from_angles, from_quaternion, skew
from robolaser.model.sensors.sensor import motion
from robolaser.model.stages import Perturbation, Stage
from robolaser.parameters import Values


def stripe_jacobian(dataset: Dataset, values: Values, T_base_flange: Array, perturb: Perturbation) -> Array:
    """Derivatives of known less predicted points in the base frame.

    Args:
        dataset: Pixels, target points, and how the scanner is built.
        values: All parameters, (c,) each.
        T_base_flange: (c or 1, n, 4, 4).
        perturb: Effects; none of them at mount, image, laser plane or light.

    Returns:
        By f, s_u, s_v, u_0, v_0, k, b, theta, w, phi, psi, t_x, t_y, t_z [m per unit], and where the target is not
        placed by its six, (c, m, 3, 14 or 20).
    """
    points = dataset.points
    P, slopes = _in_camera(perturb(Stage.PIXELS, points["pixel"][None]), values, dataset.stripe_axis)
    angles = tuple(values[name] for name in ("w", "phi", "psi"))
    bracket = from_quaternion(np.array(dataset.bracket_quat))
    R_flange_camera = bracket @ from_angles(*angles, order=dataset.angles)
    R_base_flange = T_base_flange[:, points.pose, :3, :3]
    in_flange = np.empty((*P.shape, 11))
    in_flange[..., :8] = R_flange_camera[:, None] @ slopes
    turned = P @ np.swapaxes(R_flange_camera, -1, -2)
    in_flange[..., 8:] = _turning(turned, angle_axes(*angles, order=dataset.angles) @ bracket.T)
    count = 14 if dataset.placed else 20
    c, m = common_length(P, R_base_flange, perturb(Stage.TARGET, points["xyz"][None])), len(points)
    J = np.empty((c, m, 3, count))
    J[..., :11] = -R_base_flange @ in_flange
    J[..., 11:14] = -R_base_flange
    if not dataset.placed:
        T = motion(values, "target")
        lever = perturb(Stage.TARGET, points["xyz"][None]) @ np.swapaxes(T[:, :3, :3], -1, -2)
        J[..., 14:17] = np.eye(3)
        J[..., 17:] = _turning(lever, angle_axes(*(values[f"target.{part}"] for part in ("w", "phi", "psi"))))
    return J


def _turning(points: Array, axes: Array) -> Array:
    """Moves of points (c, m, 3) by turns about each of three axes (c, 3, 3), (c, m, 3, 3): a column for each axis."""
    by_axis = points[:, None] @ np.swapaxes(skew(axes), -1, -2)  # (c, axis, m, 3)
    return np.moveaxis(by_axis, 1, -1)


def _in_camera(pixel: Array, values: Values, stripe_axis: str) -> tuple[Array, Array]:
    """Points in the camera frame (c, m, 3), and derivatives by f, s_u, s_v, u_0, v_0, k, b, theta, (c, m, 3, 8)."""
    k, b, theta = (values[name][:, None] for name in ("k", "b", "theta"))
    distorted = metric(pixel, values)
    ray = rays(undistort(distorted, values["k"]), values["f"], stripe_axis)
    cos, sin = np.cos(theta), np.sin(theta)
    facing = cos * ray[..., 0] + sin * ray[..., 2]
    with np.errstate(divide="ignore", invalid="ignore"):
        rho = b * cos / facing
    normal = np.concatenate([cos, np.zeros_like(cos), sin], axis=-1)

    r2 = (distorted**2).sum(axis=-1, keepdims=True)
    by_metric = 2.0 * k[..., None, None] * distorted[..., :, None] * distorted[..., None, :]
    by_metric += (1.0 + k[..., None] * r2)[..., None] * np.eye(2)
    pitch = np.stack([values["s_u"], values["s_v"]], axis=-1)
    centre = np.stack([values["u_0"], values["v_0"]], axis=-1)
    in_image = np.concatenate(
        [
            by_metric * (pixel - centre[:, None])[..., None, :],
            -by_metric * pitch[:, None, None],
            (distorted * r2)[..., None],
        ],
        axis=-1,
    )  # by s_u, s_v, u_0, v_0, k
    by_u, by_v = in_image[..., 0, :], in_image[..., 1, :]
    by = np.zeros((*ray.shape, 8))
    by[..., 0, 1:6], by[..., 1, 1:6] = (by_v, -by_u) if stripe_axis == "u" else (by_u, by_v)
    by[..., 2, 0] = 1.0  # the ray by f

    with np.errstate(divide="ignore", invalid="ignore"):
        grows = -(rho / facing)[..., None] * (normal[:, None, None] @ by)[..., 0, :]
        grows[..., 6] = cos / facing
        grows[..., 7] = -(b * sin + rho * (cos * ray[..., 2] - sin * ray[..., 0])) / facing
    return ray * rho[..., None], by * rho[..., None, None] + ray[..., None] * grows[..., None, :]
