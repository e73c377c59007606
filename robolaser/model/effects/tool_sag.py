"""Reflector holders and tools that deflect under gravity."""

from dataclasses import dataclass
from typing import final

import numpy as np

from robolaser.arrays import Array
from robolaser.geometry.rigid_motion import exp_so3, pose
from robolaser.model.effects.effect import Effect, Run, Stage, parameter
from robolaser.model.effects.requirements import no_mount, weight


@final
@dataclass(frozen=True)
class ToolSag(Effect):
    r"""The tool on the flange shifts by C ĝ and turns by moment × ĝ; ĝ is gravity's direction in the flange frame.

    A holder deflects by the symmetric matrix C, with the elements sag + uneven_xx, sag - uneven_xx and 0 on its
    diagonal and uneven_xy, uneven_xz, uneven_yz beside it: a holder along the flange's z axis sinks by sag across it.
    It turns in proportion to the weight's moment r × mg about the flange: `moment` is the lever r times mg over the
    rotational stiffness. A shift that is equal in all directions is indistinguishable from a shift of the base.
    """

    name = "tool_sag"
    title = "elastic deflection of the tool or reflector holder under gravity"
    clause = "the tool sags under its weight"
    caveat = "assumes that the tool deflects in proportion to gravity, for every orientation of the flange"
    remedy = "Stiffen what the flange carries, shorten it, or keep the flange's orientation constant."
    reference = "Gere, Timoshenko 1997, Mechanics of Materials, ch. 9: cantilevers under an end load; 0.05-1 mm"
    stage = Stage.FLANGE
    cause = "elasticity"
    site = "tool"
    needs = (no_mount, weight)

    sag: Array = parameter(unit="m", bound=0.02, prior_scale=2e-4)
    uneven_xx: Array = parameter(unit="m", bound=0.02, prior_scale=2e-4)
    uneven_xy: Array = parameter(unit="m", bound=0.02, prior_scale=2e-4)
    uneven_xz: Array = parameter(unit="m", bound=0.02, prior_scale=2e-4)
    uneven_yz: Array = parameter(unit="m", bound=0.02, prior_scale=2e-4)
    moment_x: Array = parameter(unit="rad", bound=0.1, prior_scale=1e-3)
    moment_y: Array = parameter(unit="rad", bound=0.1, prior_scale=1e-3)
    moment_z: Array = parameter(unit="rad", bound=0.1, prior_scale=1e-3)

    def apply(self, T_base_flange: Array, run: Run, /) -> Array:
        down = run.gravity_in_flange
        turn = np.cross(np.stack([self.moment_x, self.moment_y, self.moment_z], axis=-1)[:, None], down)
        xx, xy, xz, yz = (e[:, None] for e in (self.uneven_xx, self.uneven_xy, self.uneven_xz, self.uneven_yz))
        sag, (x, y, z) = self.sag[:, None], np.moveaxis(down, -1, 0)
        shift = np.stack([(sag + xx) * x + xy * y + xz * z, xy * x + (sag - xx) * y + yz * z, xz * x + yz * y], axis=-1)
        return T_base_flange @ pose(exp_so3(turn), shift)
