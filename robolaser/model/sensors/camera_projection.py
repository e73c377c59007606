"""OpenCV's camera: from points to pixels through a pinhole and Brown's distortion, and back."""

from typing import Any

import numpy as np

from robolaser.arrays import Array
from robolaser.duals import Dual
from robolaser.geometry.board_views import INTRINSICS
from robolaser.parameters import Values

INVERSIONS = 30  # steps of Newton's method from distorted to straight image points; mostly five settle it


def on_plane(points: Array) -> Array:
    """x/z and y/z of points in the camera frame, (..., 3) -> (..., 2); NaN behind the camera."""
    depth = np.where(points[..., 2:] > 0.0, points[..., 2:], np.nan)
    return points[..., :2] / depth


def distort(straight: Array, values: Values) -> Array:
    """Image points at unit focal length through the lens, (c, m, 2). OpenCV 4, calib3d, "Detailed Description"."""
    x, y = straight[..., 0], straight[..., 1]
    k1, k2, p1, p2, k3 = (values[name][:, None] for name in INTRINSICS[4:])
    r2 = x * x + y * y
    radial = 1.0 + r2 * (k1 + r2 * (k2 + r2 * k3))
    decentred_x = 2.0 * p1 * x * y + p2 * (r2 + 2.0 * x * x)
    decentred_y = p1 * (r2 + 2.0 * y * y) + 2.0 * p2 * x * y
    return np.stack([x * radial + decentred_x, y * radial + decentred_y], axis=-1)


def to_pixels(distorted: Array, values: Values) -> Array:
    """Distorted image points at unit focal length to pixels, (c, m, 2) [px]."""
    focal = np.stack([values["fx"], values["fy"]], axis=-1)[:, None]
    return focal * distorted + np.stack([values["cx"], values["cy"]], axis=-1)[:, None]


def project(points: Array, values: Values) -> Array:
    """Points in the camera frame to pixels, (c, m, 3) [m] -> (c, m, 2) [px]; NaN behind the camera."""
    return to_pixels(distort(on_plane(points), values), values)


def straighten(pixel: Array, values: Values) -> Array:
    """Pixels to straight image points at unit focal length, by Newton's method, (c, m, 2) [px] -> (c, m, 2).

    NaN where the lens shows nothing.
    """
    focal = np.stack([values["fx"], values["fy"]], axis=-1)[:, None]
    wanted = (pixel - np.stack([values["cx"], values["cy"]], axis=-1)[:, None]) / focal
    straight, by_axis = wanted.copy(), np.eye(2)[:, None, None]
    with np.errstate(all="ignore"):
        for _ in range(INVERSIONS):
            moving: Any = Dual(straight, np.broadcast_to(by_axis, (2, *straight.shape)), (0, 1))
            bent: Any = distort(moving, values)
            missing, by_place = wanted - bent.value, np.moveaxis(bent.slopes, 0, -1)
            determinant = by_place[..., 0, 0] * by_place[..., 1, 1] - by_place[..., 0, 1] * by_place[..., 1, 0]
            across = by_place[..., ::-1, ::-1].swapaxes(-1, -2) * np.array([[1.0, -1.0], [-1.0, 1.0]])
            straight = straight + (across @ missing[..., None])[..., 0] / determinant[..., None]
            if not (np.abs(missing) > 1e-14).any():
                break
        off = np.abs(wanted - distort(straight, values)).max(axis=-1, keepdims=True)
    return np.where(off < 1e-9, straight, np.nan)
