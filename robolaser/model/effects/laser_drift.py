"""Projectors whose beam turns as the diode warms up."""

from dataclasses import dataclass
from typing import final

import numpy as np

from robolaser.arrays import Array
from robolaser.model.effects.effect import Run, Stage, parameter
from robolaser.model.effects.requirements import warm_up
from robolaser.model.effects.thermal_state import NewtonWarming, warmed


@final
@dataclass(frozen=True)
class LaserDrift(NewtonWarming):
    r"""The laser plane turns about the point where it meets the camera's x axis: :math:`θ' = θ + \mathrm{angle}\, g`.

    g is the measured rise of temperature over its largest (`temperature_c` in the data), else
    :math:`1 - \exp(-\mathrm{progress} / τ)` with τ in shares of the run.
    """

    name = "laser_drift"
    title = "the projector's angle changes as it warms up"
    clause = "the projector drifts as it warms up"
    caveat = "holds for a warm-up like this one"
    remedy = "Switch the projector on well before measuring."
    reference = "Isheil et al. 2011, Systematic error correction of a 3D laser scanning device"
    stage = Stage.LASER_PLANE
    cause = "laser"
    site = "laser"
    needs = (warm_up,)

    angle: Array = parameter(unit="rad", bound=0.05, prior_scale=1e-3)

    def apply(self, plane: Array, run: Run, /) -> Array:
        """Turn each row's plane about the camera's y axis; it keeps its intersection with the x axis."""
        turn = (self.angle[:, None] * warmed(run, self.tau))[:, run.points.pose]
        cos, sin = np.cos(turn), np.sin(turn)
        x, y, z, d = np.moveaxis(plane, -1, 0)
        turned = x * cos - z * sin
        with np.errstate(divide="ignore", invalid="ignore"):
            kept = d * (turned / x)
        return np.stack([turned, np.broadcast_to(y, turn.shape), z * cos + x * sin, kept], axis=-1)
