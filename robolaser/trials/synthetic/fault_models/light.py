"""Faults of the line projector."""

from dataclasses import replace
from typing import Annotated, final

import numpy as np

from robolaser.arrays import Array
from robolaser.trials.synthetic.fault_model import Coin, FaultModel, log_uniform
from robolaser.trials.synthetic.run import SyntheticRun
from robolaser.trials.synthetic.scanner import Light


@final
class ProjectorRoll(
    FaultModel, effect="laser_roll", sizes=(2e-3, 6e-2), signed=True, location="laser", parameter="angle"
):
    """The projector is turned about the view by `size` [rad]: the stripe is not parallel to the image's axis."""

    def light(self, light: Light, run: SyntheticRun) -> Light:
        """Turned."""
        return replace(light, roll=light.roll + self.size)


@final
class ConicalLight(
    FaultModel, effect="laser_curvature", sizes=(3e-3, 6e-2), signed=True, location="laser", parameter="cone"
):
    """The light is a shallow cone, as a rod lens makes of a beam that does not cross it squarely.

    Its rays stand off the plane by `size` [rad].
    """

    def light(self, light: Light, run: SyntheticRun) -> Light:
        """Off the plane."""
        return replace(light, cone=light.cone + self.size)


@final
class ProjectorWarmUp(FaultModel, effect="laser_drift", sizes=(2e-4, 3e-3), signed=True, location="laser"):
    """The beam's angle drifts until the projector is warm, by `size` [rad] in the end."""

    tau: Annotated[float, log_uniform(0.08, 1.0)]  # time constant, as a share of the run

    def values(self, run: SyntheticRun) -> dict[str, float]:
        """Both are the library's."""
        return {"angle": self.size, "tau": self.tau}

    def light(self, light: Light, run: SyntheticRun) -> Light:
        """Turned by the drift so far."""
        return replace(light, theta=light.theta + self.size * run.warmed(self.tau))


@final
class FlankBias(FaultModel, effect="stripe_bias", sizes=(0.1, 2.0), signed=True, location="laser"):
    """One flank of the stripe is brighter: its centre is read beside it where the surface is tilted."""

    steep: Coin  # whether it goes with the tangent of the tilt or with its sine

    def stripe(self, tilt: Array) -> Array:
        """`size` pixels at 45 degrees, about."""
        return self.size * (np.tan(tilt) if self.steep else np.sin(tilt))
