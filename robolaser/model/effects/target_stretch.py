"""Prints that are longer in one direction."""

from dataclasses import dataclass
from typing import final

import numpy as np

from robolaser.arrays import Array
from robolaser.data.dataset import Dataset
from robolaser.model.effects.effect import Effect, Run, Stage, nonlinear, parameter
from robolaser.model.effects.requirements import flat_target

DIRECTIONS = 8  # of the grid, over half a turn


@final
@dataclass(frozen=True)
class TargetStretch(Effect):
    """The grid is longer along one direction of its plane: P' = P + stretch e (e · (P - middle) - centre).

    e is turned by `direction` from the plane's first axis, which is as near to the frame's x axis as the plane permits.
    Printers feed paper by rollers, whose diameter scales one direction alone. The point by which the grid was located
    is unknown: `centre` is its distance from the middle of the target points, along e.
    """

    name = "target_stretch"
    title = "the print is longer in one direction"
    clause = "the target is longer in one direction than stated"
    remedy = "Measure the target with a caliper along both sides: it is longer in one direction than stated."
    reference = "Strobl, Hirzinger 2011, More accurate pinhole camera calibration: aspect ratios of prints, up to 1 %"
    stage = Stage.TARGET
    cause = "target"
    site = "target"
    needs = (flat_target,)
    depends_on_trajectory = True

    stretch: Array = parameter(unit="", bound=0.05, prior_scale=3e-3)
    direction: Array = nonlinear(unit="rad", lower=-np.pi, upper=np.pi, nominal=0.0)
    centre: Array = nonlinear(unit="m", lower=-2.0, upper=2.0, nominal=0.0)

    @classmethod
    def grid(cls, dataset: Dataset, where: str) -> Array:
        """Along the sides and between them, about three centres; about the middle if a shift is equivalent."""
        centres = 0.7 * Run(dataset).target.half * np.array([-1.0, 0.0, 1.0]) if dataset.placed else [0.0]
        turns = np.linspace(-np.pi / 2, np.pi / 2, DIRECTIONS, endpoint=False)
        return np.array([[turn, centre] for centre in centres for turn in turns])

    def apply(self, points: Array, run: Run, /) -> Array:
        plane = run.target
        e = np.stack([np.cos(self.direction), np.sin(self.direction)], axis=-1) @ plane.axes[:, :2].T
        along = ((points - plane.centre) * e[:, None]).sum(axis=-1) - self.centre[:, None]
        stretched: Array = points + (self.stretch[:, None] * along)[..., None] * e[:, None]
        return stretched
