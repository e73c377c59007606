"""Projectors whose beam turns as the diode warms up."""

from dataclasses import dataclass
from typing import final

import numpy as np

from robolaser.arrays import Array
from robolaser.data.dataset import Dataset
from robolaser.model.effects.effect import CarryOver, Effect, Run, parameter
from robolaser.model.effects.requirements import warm_up
from robolaser.model.effects.run_summary import RunSummary
from robolaser.model.effects.thermal_state import carried_by_temperature, time_constant, time_constants, warmed
from robolaser.model.stages import Stage


@final
@dataclass(frozen=True)
class LaserDrift(Effect):
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
    depends_on_trajectory = True

    angle: Array = parameter(unit="rad", bound=0.05, prior_scale=1e-3)
    tau: Array = time_constant()

    @classmethod
    def grid(cls, dataset: Dataset, where: str) -> Array:
        """Time constants from a twentieth of the run to three runs."""
        return time_constants(dataset)

    def apply(self, plane: Array, run: Run, /) -> Array:
        """Turn each row's plane about the camera's y axis; it keeps its intersection with the x axis."""
        turn = (self.angle[:, None] * warmed(run, self.tau))[:, run.points.pose]
        cos, sin = np.cos(turn), np.sin(turn)
        x, y, z, d = np.moveaxis(plane, -1, 0)
        turned = x * cos - z * sin
        with np.errstate(divide="ignore", invalid="ignore"):
            kept = d * (turned / x)
        return np.stack([turned, np.broadcast_to(y, turn.shape), z * cos + x * sin, kept], axis=-1)

    def carried_to(self, run: Run, found_in: RunSummary | None) -> CarryOver:
        """It follows the thermometer."""
        return carried_by_temperature(self, run)
