"""J of eq. 18 for populations of stripe scanners, for searches by cost alone. Lee et al. 2004."""

from typing import final

import numpy as np

from robolaser.arrays import Array
from robolaser.data.dataset import Dataset
from robolaser.geometry.camera import laser_plane
from robolaser.geometry.rigid_motion import carry, inverse
from robolaser.model.sensors.scanner_geometry import mount
from robolaser.model.stages import Perturbation
from robolaser.parameters import Values

AT_ONCE = 8_000  # candidates times rows: a dozen arrays of so many numbers stay in a processor's second-level cache


@final
class StripeCost:
    """J of a data set with a placed target, for an arm that is the same for all candidates.

    The target is carried to the flange frame once for all of them: distances stay what they are, and no pose is left.
    """

    def __init__(self, dataset: Dataset) -> None:
        self._dataset = dataset
        self._T_base_flange: Array | None = None

    def __call__(self, values: Values, T_base_flange: Array) -> Array:
        """J, (c,) [m²]; infinite at the model's poles.

        Args:
            values: The scanner's parameters, (c,) each.
            T_base_flange: (1, n, 4, 4); what follows from it is kept for the next call.
        """
        if self._T_base_flange is not T_base_flange:
            self._T_base_flange, points = T_base_flange, self._dataset.points
            pixel = points["pixel"]
            self._image = np.ascontiguousarray((pixel[:, ::-1] if self._dataset.stripe_axis == "u" else pixel).T)
            self._known = np.ascontiguousarray(carry(inverse(T_base_flange), points.pose, points["xyz"][None])[0].T)
        x_0, y_0, s_x, s_y = self._axes(values)
        planes, held = laser_plane(values)[:, 0], mount(self._dataset, values, Perturbation())[:, 0]
        k, f = values["k"], values["f"]
        J = np.empty(len(f))
        step = max(1, AT_ONCE // self._image.shape[1])
        for first in range(0, len(J), step):
            part = slice(first, first + step)
            at = tuple(value[part, None] for value in (x_0, y_0, s_x, s_y, k, f))
            J[part] = self._squares(at, planes[part], held[part])
        return np.where(np.isfinite(J), J, np.inf)

    def _axes(self, values: Values) -> tuple[Array, ...]:
        """Origins of the camera's x and y in the image [px] and their pitches [m/px]."""
        v = values
        if self._dataset.stripe_axis == "u":
            return v["v_0"], v["u_0"], v["s_v"], -v["s_u"]
        return v["u_0"], v["v_0"], v["s_u"], v["s_v"]

    def _squares(self, at: tuple[Array, ...], planes: Array, T_flange_camera: Array) -> Array:
        x_0, y_0, s_x, s_y, k, f = at
        n_x, n_y, n_z, d = planes.T[:, :, None]
        R = T_flange_camera[:, :3, :3]
        known = np.swapaxes(R, 1, 2) @ (self._known - T_flange_camera[:, :3, 3:])
        with np.errstate(all="ignore"):
            x, y = (self._image[0] - x_0) * s_x, (self._image[1] - y_0) * s_y
            grown = x * x
            grown += y * y
            grown *= k
            grown += 1.0
            x *= grown
            y *= grown
            rho = n_x * x
            rho += n_y * y
            rho += n_z * f
            np.divide(d, rho, out=rho)
            x *= rho
            y *= rho
            rho *= f
            known[:, 0] -= x
            known[:, 1] -= y
            known[:, 2] -= rho
            flat = known.reshape(len(known), -1)
            return np.asarray(np.einsum("ij,ij->i", flat, flat))
