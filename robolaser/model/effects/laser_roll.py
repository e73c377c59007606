"""Laser planes turned about the optical axis, so that the stripe is not parallel to an image axis."""

from dataclasses import dataclass
from typing import final

import numpy as np

from robolaser.arrays import Array
from robolaser.model.effects.effect import Effect, Run, Stage, parameter


@final
@dataclass(frozen=True)
class LaserRoll(Effect):
    r"""The third degree of freedom of the laser plane: :math:`(x \cos γ + y \sin γ) \cos θ + z \sin θ = b \cos θ`."""

    name = "laser_roll"
    title = "the laser plane is not parallel to the image's axis"
    clause = "the laser plane is rolled against the image"
    remedy = "Turn the projector in its mount, or use the corrected model."
    reference = "Lee et al. 2004, eqs. 5-6, which take γ = 0"
    stage = Stage.LASER_PLANE
    cause = "laser"
    site = "laser"

    angle: Array = parameter(unit="rad", bound=0.5, prior_scale=0.02)

    def apply(self, plane: Array, run: Run, /) -> Array:
        cos, sin = np.cos(self.angle)[:, None], np.sin(self.angle)[:, None]
        x, y, z, d = np.moveaxis(plane, -1, 0)
        turned = x * cos - y * sin, x * sin + y * cos
        unturned = np.broadcast_to(z, turned[0].shape), np.broadcast_to(d, turned[0].shape)
        return np.stack([*turned, *unturned], axis=-1)
