"""Faults of the target."""

from typing import Annotated, final

import numpy as np

from robolaser.arrays import Array
from robolaser.trials.synthetic.fault_model import Angle, FaultModel, OnTarget, uniform
from robolaser.trials.synthetic.run import SyntheticRun


@final
class PrintScale(
    FaultModel, effect="target_scale", sizes=(5e-4, 1.2e-2), signed=True, location="target", parameter="scale"
):
    """The target was printed too large or too small: drawn distances are off by the share `size`."""

    aside: OnTarget  # the grid's origin

    def printed(self, along: Array, run: SyntheticRun) -> Array:
        """Scaled about the grid's origin."""
        origin = run.radius * np.array(self.aside)
        return origin + (along - origin) / (1.0 + self.size)


@final
class FedTooFast(
    FaultModel, effect="target_stretch", sizes=(1e-3, 1.5e-2), signed=True, location="target", parameter="stretch"
):
    """The printer fed its paper too fast: the drawing is longer along that direction alone, by the share `size`."""

    heading: Angle

    def printed(self, along: Array, run: SyntheticRun) -> Array:
        """Shorter that way, as the drawing has it."""
        fed = np.array([np.cos(self.heading), np.sin(self.heading)])
        return np.asarray(along - (self.size / (1.0 + self.size) * (along @ fed))[:, None] * fed)


@final
class CurvedTarget(FaultModel, effect="target_warp", sizes=(1e-4, 1.5e-3), location="target"):
    """The target is not flat: a roof tile, a saddle or a wave."""

    shape: Annotated[str, lambda where, run, rng: str(rng.choice(["tile", "saddle", "wave"]))]
    heading: Angle
    length: Annotated[float, uniform(1.5, 4.0)]  # of the wave, over the target's radius

    def height(self, along: Array, run: SyntheticRun) -> Array:
        """About `size` [m] at the rim."""
        cos, sin = np.cos(self.heading), np.sin(self.heading)
        x, y = along[:, 0] / run.radius, along[:, 1] / run.radius
        x, y = cos * x + sin * y, cos * y - sin * x
        shapes = {"tile": x**2, "saddle": x * y, "wave": np.sin(2 * np.pi * x / self.length)}
        return np.asarray(self.size * shapes[self.shape])


@final
class TargetDent(FaultModel, effect="dented_target", sizes=(3e-4, 1.5e-3), location="target", classes=("target",)):
    """The target has a bell-shaped dent of some centimetres; the library has no such effect."""

    aside: OnTarget
    width: Annotated[float, uniform(0.03, 0.09)]  # [m]

    def height(self, along: Array, run: SyntheticRun) -> Array:
        """`size` [m] deep."""
        away = (along - run.radius * np.array(self.aside)) / self.width
        return np.asarray(-self.size * np.exp(-0.5 * (away**2).sum(axis=1)))
