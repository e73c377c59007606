"""Projectors whose beam turns as the diode warms up."""

from dataclasses import dataclass
from typing import ClassVar, final

import numpy as np

from robolaser.arrays import Array
from robolaser.data.dataset import Dataset
from robolaser.model.effects.effect import Effect, Scene, parameter, shape
from robolaser.model.effects.lacking import no_stripe, no_warming
from robolaser.model.effects.warming import LONGEST, SHORTEST, USUAL, time_constants, warmed
from robolaser.model.stages import Stage


@final
@dataclass(frozen=True)
class LaserDrift(Effect):
    r"""The sheet turns about the line where it meets the camera's x axis: :math:`θ' = θ + \mathrm{angle}\, g`.

    g is the measured rise of temperature over its largest (`temperature_c` in the data), else
    :math:`1 - \exp(-\mathrm{progress} / τ)` with τ in shares of the run.
    """

    name: ClassVar[str] = "laser_drift"
    title: ClassVar[str] = "the projector's angle changes as it warms up"
    reference: ClassVar[str] = "Isheil et al. 2011, Systematic error correction of a 3D laser scanning device"
    stage: ClassVar[Stage] = Stage.SHEET
    depends_on_trajectory: ClassVar[bool] = True

    angle: Array = parameter(unit="rad", bound=0.05, prior_scale=1e-3)
    tau: Array = shape(unit="", lower=SHORTEST, upper=LONGEST, nominal=USUAL)

    @classmethod
    def missing(cls, dataset: Dataset) -> str:
        """A light sheet, and a thermometer or the time."""
        return no_stripe(dataset, "light sheet") or no_warming(dataset)

    @classmethod
    def places(cls, dataset: Dataset) -> tuple[str, ...]:
        """The projector of a stripe scanner."""
        return () if cls.missing(dataset) else ("laser",)

    @classmethod
    def grid(cls, dataset: Dataset, where: str) -> Array:
        """Time constants from a twentieth of the run to three runs."""
        return time_constants(dataset)

    def apply(self, value: Array, scene: Scene) -> Array:
        """Turn each row's plane about the camera's y axis, its place on the x axis kept."""
        turn = (self.angle[:, None] * warmed(scene, self.tau))[:, scene.points.pose]
        cos, sin = np.cos(turn), np.sin(turn)
        x, y, z, d = np.moveaxis(value, -1, 0)
        turned = x * cos - z * sin
        with np.errstate(divide="ignore", invalid="ignore"):
            kept = d * (turned / x)
        return np.stack([turned, np.broadcast_to(y, turn.shape), z * cos + x * sin, kept], axis=-1)
