"""Faults of the line projector."""

from dataclasses import dataclass, replace
from typing import Any, ClassVar, final

import numpy as np

from robolaser.arrays import Array
from robolaser.trials.synthetic.fault_model import FaultModel
from robolaser.trials.synthetic.light import Light
from robolaser.trials.synthetic.run import SyntheticRun


@final
@dataclass(frozen=True)
class ProjectorRoll(FaultModel):
    """The projector is turned about the view by `size` [rad]: the stripe is not parallel to the image's axis."""

    effect: ClassVar[str] = "laser_roll"
    sizes: ClassVar[tuple[float, float]] = (2e-3, 6e-2)
    signed: ClassVar[bool] = True
    location: ClassVar[str | None] = "laser"

    def values(self, run: SyntheticRun) -> dict[str, float]:
        """Of the library's number."""
        return {"angle": self.size}

    def light(self, light: Light, run: SyntheticRun) -> Light:
        """Turned."""
        return replace(light, roll=light.roll + self.size)


@final
@dataclass(frozen=True)
class ConicalLight(FaultModel):
    """The light is a shallow cone, as a rod lens makes of a beam that does not cross it squarely.

    Its rays stand off the plane by `size` [rad].
    """

    effect: ClassVar[str] = "laser_curvature"
    sizes: ClassVar[tuple[float, float]] = (3e-3, 6e-2)
    signed: ClassVar[bool] = True
    location: ClassVar[str | None] = "laser"

    def values(self, run: SyntheticRun) -> dict[str, float]:
        """Of the library's numbers."""
        return {"cone": self.size}

    def light(self, light: Light, run: SyntheticRun) -> Light:
        """Off the plane."""
        return replace(light, cone=light.cone + self.size)


@final
@dataclass(frozen=True)
class ProjectorWarmUp(FaultModel):
    """The beam's angle drifts until the projector is warm, with a time constant of its own."""

    effect: ClassVar[str] = "laser_drift"
    sizes: ClassVar[tuple[float, float]] = (2e-4, 3e-3)
    signed: ClassVar[bool] = True
    location: ClassVar[str | None] = "laser"

    tau: float

    @classmethod
    def sample_form(cls, where: str, run: SyntheticRun, rng: np.random.Generator) -> tuple[Any, ...]:
        """Time constant, as a share of the run."""
        return (float(np.exp(rng.uniform(np.log(0.08), np.log(1.0)))),)

    def values(self, run: SyntheticRun) -> dict[str, float]:
        """Of the library's numbers."""
        return {"angle": self.size, "tau": self.tau}

    def light(self, light: Light, run: SyntheticRun) -> Light:
        """By `size` [rad] in the end."""
        return replace(light, theta=light.theta + self.size * run.warmed(self.tau))


@final
@dataclass(frozen=True)
class FlankBias(FaultModel):
    """One flank of the stripe is brighter: its centre is read beside it where the surface is tilted."""

    effect: ClassVar[str] = "stripe_bias"
    sizes: ClassVar[tuple[float, float]] = (0.1, 2.0)
    signed: ClassVar[bool] = True
    location: ClassVar[str | None] = "laser"

    steep: bool

    @classmethod
    def sample_form(cls, where: str, run: SyntheticRun, rng: np.random.Generator) -> tuple[Any, ...]:
        """Whether it goes with the tangent of the tilt or with its sine."""
        return (bool(rng.random() < 0.5),)

    def stripe(self, tilt: Array) -> Array:
        """`size` pixels at 45 degrees, about."""
        return self.size * (np.tan(tilt) if self.steep else np.sin(tilt))
