"""Printed targets that are larger or smaller than stated."""

from dataclasses import dataclass
from typing import final

import numpy as np

from robolaser.arrays import Array
from robolaser.data.dataset import Dataset
from robolaser.model.effects.effect import Effect, Run, Stage, nonlinear, parameter
from robolaser.model.effects.requirements import flat_target


@final
@dataclass(frozen=True)
class TargetScale(Effect):
    """The grid's scale, in its plane: P' = P + scale (P - centre) without the part along the normal.

    A grid that was located by one of its points grows from that unknown point: the centre is a nonlinear parameter,
    along the plane's axes from the middle of the target points.
    """

    name = "target_scale"
    title = "wrong scale of the printed grid"
    clause = "the target is printed to a wrong scale"
    caveat = "an arm whose reach is too long or too short by one factor looks the same"
    remedy = "Measure the target with a caliper: its squares do not have the stated size."
    reference = "Strobl, Hirzinger 2011, More accurate pinhole camera calibration; printers: up to 1.5 %"
    stage = Stage.TARGET
    cause = "target"
    site = "target"
    needs = (flat_target,)
    depends_on_trajectory = True

    scale: Array = parameter(unit="", bound=0.2, prior_scale=5e-3)
    centre_x: Array = nonlinear(unit="m", lower=-2.0, upper=2.0, nominal=0.0)
    centre_y: Array = nonlinear(unit="m", lower=-2.0, upper=2.0, nominal=0.0)

    @classmethod
    def grid(cls, dataset: Dataset, where: str) -> Array:
        """The middle of the target and eight points around it; only the middle if a target shift is equivalent."""
        if not dataset.placed:
            return np.zeros((1, 2))
        half = Run(dataset).target.half
        return half * np.array([[x, y] for x in (0.0, -0.7, 0.7) for y in (0.0, -0.7, 0.7)])

    def apply(self, points: Array, run: Run, /) -> Array:
        plane = run.target
        flat = plane.axes[:, :2]
        centre = np.stack([self.centre_x, self.centre_y], axis=-1) @ flat.T
        across = (points - plane.centre) @ (flat @ flat.T)
        return points + self.scale[:, None, None] * (across - centre[:, None])
