"""Targets that are not flat."""

from dataclasses import dataclass
from typing import final

import numpy as np

from robolaser.arrays import Array
from robolaser.model.effects.effect import Effect, Run, Stage, parameter
from robolaser.model.effects.requirements import flat_target

FIELD = 1.2  # half the extent of the field of waves over that of the points: a wave need not be even beyond the points
WAVES = 4  # the most half waves along either side


@final
@dataclass(frozen=True)
class TargetWarp(Effect):
    """The target's height along its normal: a bow xx ξ² + xy ξ η + yy η², and waves on top of it.

    ξ and η are coordinates on the target from the middle of its points, over half their larger extent; ξ is as near to
    the frame's x axis as the plane permits (to y on a plane across x). `wave_2_1` is the height of two half waves along
    ξ times one along η, over a field a fifth larger than the points'. Height and slope of the whole (`z`, `x`, `y`)
    count because a placed target was located by a part of it.
    """

    name = "target_warp"
    title = "the target is not flat"
    clause = "the target is not flat"
    caveat = "the height is known where points were seen, not beyond"
    remedy = "Use a stiffer target, or glue it to glass."
    reference = "Strobl, Hirzinger 2011, More accurate pinhole camera calibration; 0.1 mm good, 0.5-3 poor"
    stage = Stage.TARGET
    cause = "target"
    site = "target"
    needs = (flat_target,)
    depends_on_trajectory = True

    xx: Array = parameter(unit="m", bound=0.02, prior_scale=5e-4)
    xy: Array = parameter(unit="m", bound=0.02, prior_scale=5e-4)
    yy: Array = parameter(unit="m", bound=0.02, prior_scale=5e-4)
    z: Array = parameter(unit="m", bound=0.02, prior_scale=5e-4)
    x: Array = parameter(unit="m", bound=0.02, prior_scale=5e-4)
    y: Array = parameter(unit="m", bound=0.02, prior_scale=5e-4)
    wave_0_2: Array = parameter(unit="m", bound=3e-3, prior_scale=2e-4)
    wave_0_3: Array = parameter(unit="m", bound=3e-3, prior_scale=2e-4)
    wave_0_4: Array = parameter(unit="m", bound=3e-3, prior_scale=2e-4)
    wave_1_1: Array = parameter(unit="m", bound=3e-3, prior_scale=2e-4)
    wave_1_2: Array = parameter(unit="m", bound=3e-3, prior_scale=2e-4)
    wave_1_3: Array = parameter(unit="m", bound=3e-3, prior_scale=2e-4)
    wave_1_4: Array = parameter(unit="m", bound=3e-3, prior_scale=2e-4)
    wave_2_0: Array = parameter(unit="m", bound=3e-3, prior_scale=2e-4)
    wave_2_1: Array = parameter(unit="m", bound=3e-3, prior_scale=2e-4)
    wave_2_2: Array = parameter(unit="m", bound=3e-3, prior_scale=2e-4)
    wave_2_3: Array = parameter(unit="m", bound=3e-3, prior_scale=2e-4)
    wave_3_0: Array = parameter(unit="m", bound=3e-3, prior_scale=2e-4)
    wave_3_1: Array = parameter(unit="m", bound=3e-3, prior_scale=2e-4)
    wave_3_2: Array = parameter(unit="m", bound=3e-3, prior_scale=2e-4)
    wave_4_0: Array = parameter(unit="m", bound=3e-3, prior_scale=2e-4)
    wave_4_1: Array = parameter(unit="m", bound=3e-3, prior_scale=2e-4)

    def apply(self, points: Array, run: Run, /) -> Array:
        plane = run.target
        xi, eta = np.moveaxis((points - plane.centre) @ plane.axes[:, :2] / plane.half, -1, 0)
        bow = self.xx[:, None] * xi**2 + self.xy[:, None] * xi * eta + self.yy[:, None] * eta**2
        lift = bow + self.z[:, None] + self.x[:, None] * xi + self.y[:, None] * eta
        along, across = (_cosines(np.pi * (coordinate / FIELD + 1.0) / 2.0) for coordinate in (xi, eta))
        waves = [name for name, *_ in self.amplitudes() if name.startswith("wave_")]
        orders = [tuple(map(int, name.split("_")[1:])) for name in waves]
        shapes = np.stack([along[i] * across[j] for i, j in orders], axis=1)
        sizes = np.stack([getattr(self, name) for name in waves], axis=1)
        lift = lift + (sizes[:, None] @ shapes)[:, 0]
        lifted: Array = points + lift[..., None] * plane.axes[:, 2]
        return lifted


def _cosines(phase: Array) -> list[Array]:
    """cos(i phase) for i from 0 to `WAVES`, by Chebyshev's recurrence."""
    cosines = [np.ones_like(phase), np.cos(phase)]
    for _ in range(WAVES - 1):
        cosines.append(2.0 * cosines[1] * cosines[-1] - cosines[-2])
    return cosines
