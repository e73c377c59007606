"""Camera and laser plane: pixel → viewing ray → point on the plane. Lee et al. 2004, eqs. 1-6."""

import numpy as np

from robolaser.arrays import Array
from robolaser.parameters import Values


def metric(pixel: Array, values: Values) -> Array:
    """Pixels on the image plane, still distorted. Eq. 4, corrected.

    Args:
        pixel: u and v, (c, m, 2) [px].
        values: Uses `s_u`, `s_v` [m/px], `u_0`, `v_0` [px].

    Returns:
        Coordinates from the principal point, (c, m, 2) [m].
    """
    centre = np.stack([values["u_0"], values["v_0"]], axis=-1)[:, None]
    pitch = np.stack([values["s_u"], values["s_v"]], axis=-1)[:, None]
    return (pixel - centre) * pitch


def undistort(distorted: Array, k: Array) -> Array:
    """Take radial distortion off, (c, m, 2) [m] and k (c,) [1/m²] -> (c, m, 2) [m]. Eqs. 2-3."""
    r2 = distorted[..., :1] ** 2 + distorted[..., 1:] ** 2
    return distorted * (1.0 + k[:, None, None] * r2)


def rays(undistorted: Array, f: Array, stripe_axis: str) -> Array:
    """Viewing rays in the camera frame, z along the view and as long as f.

    Args:
        undistorted: (c, m, 2) [m].
        f: Effective focal length, (c,) [m].
        stripe_axis: "u" puts x along image v and y against image u, "v" x along u and y along v.

    Returns:
        (c, m, 3) [m].
    """
    u, v = undistorted[..., 0], undistorted[..., 1]
    x, y = (v, -u) if stripe_axis == "u" else (u, v)
    return np.stack([x, y, np.broadcast_to(f[:, None], x.shape)], axis=-1)


def laser_plane(values: Values) -> Array:
    """The plane of the laser: n · P = d, (c, 1, 4) as (n, d). x cos θ + z sin θ = b cos θ; eqs. 5-6."""
    b, theta = values["b"], values["theta"]
    cos, sin = np.cos(theta), np.sin(theta)
    return np.stack([cos, np.zeros_like(cos), sin, b * cos], axis=-1)[:, None]


def intersect(ray: Array, plane: Array) -> Array:
    """Intersection of each ray with the laser plane. Eqs. 5-6.

    Args:
        ray: From the optical centre, (c, m, 3).
        plane: (n, d) of each ray's plane, (c, m or 1, 4).

    Returns:
        Points in the camera frame, (c, m, 3) [m]; not finite where a ray is parallel to the plane.
    """
    facing = (ray * plane[..., :3]).sum(axis=-1)
    with np.errstate(divide="ignore", invalid="ignore"):
        point: Array = ray * (plane[..., 3] / facing)[..., None]
    return point
