"""The peer: the paper's cost in plain vectorised NumPy, as whoever knows NumPy writes it down from the equations."""

from collections.abc import Callable
from dataclasses import dataclass
from typing import final

import numpy as np

from robolaser.arrays import Array
from robolaser.data.dataset import Dataset
from robolaser.geometry.rigid_motion import from_quaternion


@final
@dataclass(frozen=True)
class Plain:
    """A data set laid out for broadcasting over candidates and points.

    Attributes:
        pixel: (m, 2) [px].
        xyz: Target points in the base frame, (m, 3) [m].
        R: Rotation of T_base_flange of each point's pose, (m, 3, 3).
        t: Its translation, (m, 3) [m].
        bracket: Nominal turn of the camera on the flange, (3, 3).
    """

    pixel: Array
    xyz: Array
    R: Array
    t: Array
    bracket: Array

    @classmethod
    def of(cls, dataset: Dataset) -> "Plain":
        """The stripe data set with a placed target."""
        points = dataset.points
        assert points.pixel is not None
        assert points.xyz is not None
        T = dataset.flange()[points.pose]
        bracket = from_quaternion(np.array(dataset.bracket_quat))
        return cls(points.pixel, points.xyz, T[:, :3, :3], T[:, :3, 3], bracket)

    def _in_camera(self, x: Array) -> tuple[Array, Array, Array]:
        """Points in the camera frame (c, m, 3) [m]; rotation (c, 3, 3) and translation (c, 1, 3) of T_flange_camera."""
        f, s_u, s_v, u_0, v_0, k, b, theta, w, phi, psi = x.T[:11, :, None]
        u = s_u * (self.pixel[:, 0] - u_0)
        v = s_v * (self.pixel[:, 1] - v_0)
        stretch = 1 + k * (u**2 + v**2)
        u, v = u * stretch, v * stretch
        rho = b / (v + f * np.tan(theta))
        P_camera = rho[..., None] * np.stack([v, -u, np.broadcast_to(f, u.shape)], axis=-1)
        turn = np.einsum("cij,cjk,ckl->cil", about(w[:, 0], 0), about(phi[:, 0], 1), about(psi[:, 0], 2))
        return P_camera, self.bracket @ turn, x[:, None, 11:14]

    def residuals(self, x: Array) -> Array:
        """E of eq. 17, candidates (c, 14) -> (c, m, 3) [m]."""
        P_camera, R, t = self._in_camera(x)
        P_flange = np.einsum("cij,cmj->cmi", R, P_camera) + t
        P_base = np.einsum("mij,cmj->cmi", self.R, P_flange) + self.t
        return self.xyz - P_base

    def residuals_by_matmul(self, x: Array) -> Array:
        """The same by products of stacked matrices."""
        P_camera, R, t = self._in_camera(x)
        P_flange = P_camera @ np.swapaxes(R, 1, 2) + t
        P_base: Array = (self.R @ P_flange[..., None])[..., 0] + self.t
        return self.xyz - P_base

    def cost(self, x: Array) -> Array:
        """J of eq. 18, (c, 14) -> (c,) [m²]."""
        return _summed(self.residuals, x)

    def cost_by_matmul(self, x: Array) -> Array:
        """The same."""
        return _summed(self.residuals_by_matmul, x)


def _summed(residuals: Callable[[Array], Array], x: Array) -> Array:
    with np.errstate(all="ignore"):
        E = residuals(x)
        J = np.einsum("cmi,cmi->c", E, E)
    return np.where(np.isfinite(J), J, np.inf)


def about(angle: Array, axis: int) -> Array:
    """Turns about one axis, (c,) [rad] -> (c, 3, 3)."""
    R = np.zeros((len(angle), 3, 3))
    i, j = (axis + 1) % 3, (axis + 2) % 3
    R[:, axis, axis] = 1
    R[:, i, i] = R[:, j, j] = np.cos(angle)
    R[:, j, i] = np.sin(angle)
    R[:, i, j] = -R[:, j, i]
    return R
