"""Brackets that deflect under the sensor's weight, by its direction in the flange."""

from dataclasses import dataclass
from typing import final

import numpy as np

from robolaser.arrays import Array
from robolaser.geometry.rigid_motion import exp_so3, pose
from robolaser.model.effects.effect import Effect, Run, Stage, parameter
from robolaser.model.effects.requirements import weight


@final
@dataclass(frozen=True)
class HandEyeSag(Effect):
    r"""The camera sinks by sag ĝ and turns by moment × ĝ + U ĝ; ĝ is gravity's direction in the flange frame.

    A bracket of stiffness k deflects under the weight mg by mg / k, and turns in proportion to the weight's moment
    r × mg about the flange: `moment` is the lever r, from the flange to the centre of mass, times mg over the
    rotational stiffness. Where that differs between the flange's axes, U holds the differences: it is symmetric and
    zero on its diagonal, and `uneven_x`, `uneven_y`, `uneven_z` each join the two other axes. The deflection is zero
    without weight: the hand-eye is of the unloaded bracket. The camera turns about its optical centre.
    """

    name = "hand_eye_sag"
    title = "elastic deflection of the bracket under gravity"
    clause = "the sensor's bracket sags"
    caveat = "assumes that the bracket deflects in proportion to gravity, for every orientation of the flange"
    remedy = "Stiffen the sensor's bracket, shorten it, or keep the flange's orientation constant."
    reference = "Gere, Timoshenko 1997, Mechanics of Materials, ch. 9: cantilevers under an end load; 0.05-1 mm"
    stage = Stage.MOUNT
    cause = "elasticity"
    site = "hand_eye"
    needs = (weight,)

    sag: Array = parameter(unit="m", bound=0.02, prior_scale=3e-4, lower=0.0)
    moment_x: Array = parameter(unit="rad", bound=0.1, prior_scale=1e-3)
    moment_y: Array = parameter(unit="rad", bound=0.1, prior_scale=1e-3)
    moment_z: Array = parameter(unit="rad", bound=0.1, prior_scale=1e-3)
    uneven_x: Array = parameter(unit="rad", bound=0.1, prior_scale=5e-4)
    uneven_y: Array = parameter(unit="rad", bound=0.1, prior_scale=5e-4)
    uneven_z: Array = parameter(unit="rad", bound=0.1, prior_scale=5e-4)

    def apply(self, T_flange_camera: Array, run: Run, /) -> Array:
        down = run.gravity_in_flange
        turn = np.cross(np.stack([self.moment_x, self.moment_y, self.moment_z], axis=-1)[:, None], down)
        x, y, z = (each[:, None] for each in (self.uneven_x, self.uneven_y, self.uneven_z))
        g = np.moveaxis(down, -1, 0)
        turn = turn + np.stack([z * g[1] + y * g[2], z * g[0] + x * g[2], y * g[0] + x * g[1]], axis=-1)
        R, t = T_flange_camera[..., :3, :3], T_flange_camera[..., :3, 3]
        return pose(exp_so3(turn) @ R, t + self.sag[:, None, None] * down)
