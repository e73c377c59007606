"""Cameras whose image moves, turns and grows as they warm up."""

from dataclasses import dataclass
from typing import final

import numpy as np

from robolaser.arrays import Array
from robolaser.data.dataset import Dataset
from robolaser.model.effects.effect import Run, Stage, nonlinear, parameter
from robolaser.model.effects.requirements import camera_alone_on_flange, warm_up
from robolaser.model.effects.run import temperature_rise
from robolaser.model.effects.thermal_state import Warming, crept

SHARPEST = 20.0  # by then the camera is warm after a tenth of the run


@final
@dataclass(frozen=True)
class CameraDrift(Warming):
    r"""A pixel at :math:`p` from the image's middle moves by :math:`g (t + \mathrm{growth}\,p + \mathrm{turn}\,Jp)`.

    J turns from u to v, and t is (x, y); g is the measured rise of temperature over its largest (`temperature_c` in the
    data), else of a creep with `settling`: even with 0. The amplitudes are the accumulated drift at the end.
    """

    name = "camera_drift"
    title = "the camera's image moves as it warms up"
    clause = "the camera drifts as it warms up"
    caveat = "holds for a warm-up like this one; a bracket that creeps looks nearly the same"
    remedy = "Switch the camera on well before measuring."
    reference = "Handel 2007, Analyzing the influences of camera warm-up effects on image acquisition"
    stage = Stage.PIXELS
    cause = "camera"
    site = "camera"
    needs = (camera_alone_on_flange, warm_up)

    x: Array = parameter(unit="px", bound=20.0, prior_scale=0.5)
    y: Array = parameter(unit="px", bound=20.0, prior_scale=0.5)
    growth: Array = parameter(unit="", bound=0.02, prior_scale=3e-4)
    turn: Array = parameter(unit="rad", bound=0.02, prior_scale=2e-4)
    # from even drift to one that settles early
    settling: Array = nonlinear(
        unit="", lower=0.0, upper=SHARPEST, nominal=0.0, tried=(0.0, 1.5, 3.0, 5.0, 8.0, 13.0, SHARPEST)
    )

    @classmethod
    def grid(cls, dataset: Dataset, where: str) -> Array:
        """Only one where temperatures were measured: these need no settling."""
        tried = super().grid(dataset, where)
        return tried if temperature_rise(dataset.poses) is None else tried[:1]

    def apply(self, pixel: Array, run: Run, /) -> Array:
        risen = crept(run.progress, self.settling) if run.rise is None else run.rise[None]
        size = run.dataset.image_px
        middle = run.reference.points["pixel"].mean(axis=0) if size is None else 0.5 * np.array(size)
        away = pixel - middle
        shift = np.stack([self.x, self.y], axis=-1)[:, None]
        growth, turn = self.growth[:, None, None], self.turn[:, None, None]
        moved = shift + growth * away + turn * np.stack([-away[..., 1], away[..., 0]], axis=-1)
        cold: Array = pixel - risen[:, run.points.pose, None] * moved
        return cold
