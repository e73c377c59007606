"""Stripes whose bright centre is not the centre of the laser plane, on a tilted surface."""

from dataclasses import dataclass, replace
from typing import final

import numpy as np

from robolaser.arrays import Array
from robolaser.model.effects.effect import CarryOver, Effect, Run, RunSummary, Stage, parameter
from robolaser.model.effects.requirements import flat_target, laser_plane

ORDINARY_DEG = 30.0  # of tilt of an ordinary surface


@final
@dataclass(frozen=True)
class StripeBias(Effect):
    r"""The pixel across the stripe shifts by :math:`\mathrm{slope} \tan(\mathrm{tilt})`.

    The tilt is the signed angle between the view and the surface's normal, across the stripe, by the nominal model; the
    surface is the plane of the target points.
    """

    name = "stripe_bias"
    title = "the stripe's centre is biased with the tilt of the surface"
    clause = "the stripe's centre is biased where the surface is tilted"
    caveat = "holds for this target's surface"
    remedy = "View surfaces at normal incidence, expose shorter, or use a matt target."
    reference = "Feng, Liu, Xi 2001, Analysis of digitizing errors of a laser scanning system; 0.05-0.3 px"
    stage = Stage.PIXELS
    cause = "laser"
    site = "laser"
    needs = (laser_plane, flat_target)
    depends_on_trajectory = True

    slope: Array = parameter(unit="px", bound=5.0, prior_scale=0.2)
    tilt: float | None = None  # tangent of a tilt that is assumed everywhere instead

    def apply(self, pixel: Array, run: Run, /) -> Array:
        tilt = run.tilt if self.tilt is None else np.full(pixel.shape[1], self.tilt)
        shift = self.slope[:, None] * tilt
        return pixel + shift[..., None] * run.across_stripe

    def carried_to(self, run: Run, found_in: RunSummary | None) -> CarryOver:
        """It needs the tilt of the surface, which is known for target points only."""
        if not (reason := self.hindrance(run)):
            return CarryOver(self)
        tilted = replace(self, tilt=float(np.tan(np.radians(ORDINARY_DEG))))
        assumption = f"On a surface tilted by {ORDINARY_DEG:.0f}°"
        return CarryOver(None, reason, assumption, alternatives=(tilted,))

    def hindrance(self, run: Run) -> str:
        """No target points, or no flat target."""
        known = run.points.xyz is not None and not self.missing(run.dataset)
        return "" if known else "the tilt of the surface is not known"
