"""The calibration with the parameters left out that follow from the others."""

from typing import Any, final

import numpy as np
from pymoo.core.problem import Problem

from robolaser.arrays import Array
from robolaser.scanner import Model
from robolaser.seams import Seam

BREAKS_SCALE = (Seam.SHEET, Seam.LIGHT, Seam.MOUNT)  # with effects here, points need not grow with the baseline


@final
class ReducedCalibration(Problem):
    """Minimise J in the parameters that do not follow from the others; the others are the best within their bounds.

    Of a stripe scanner's fourteen there remain camera and tilt of the sheet, six numbers with the focal length held; of
    a tracker and of sockets none. Numbers of effects come on top. `F` is J [m²] of the completed candidate, infinite at
    the model's poles.
    """

    def __init__(self, model: Model) -> None:
        """Ask for the parameters of a model that do not follow from the others."""
        self.model = model
        sensor = model.sensor
        free = model.parameters.without((*sensor.eliminated, *sensor.held))
        self._free = free
        self._rounds = 2 if any(suspect.kind.seam in BREAKS_SCALE for suspect in model.suspects) else 1
        self.names = free.names
        super().__init__(n_var=len(free), n_obj=1, xl=free.lower, xu=free.upper, vtype=float)

    def _evaluate(self, x: Array, out: dict[str, Any], *args: Any, **kwargs: Any) -> None:
        out["F"] = self.model.cost(self.completed(x))[:, None]

    def completed(self, x: Array) -> Array:
        """Candidates of this problem (c, n_var) as candidates of the whole model (c, d), within its bounds."""
        model, whole = self.model, self.model.parameters
        held = dict(zip(whole.names, np.tile(whole.nominal, (len(x), 1)).T, strict=True))
        values = {name: held[name] for name in model.sensor.held} | dict(self._free.values(x))
        bend = model.bend(values)
        T_base_flange = model.flange(values, bend)
        for _ in range(self._rounds):
            values |= model.sensor.complete(values, T_base_flange, bend, whole)
        stacked = np.stack([np.broadcast_to(values[name], len(x)) for name in whole.names], axis=-1)
        return np.asarray(np.clip(stacked, whole.lower, whole.upper))
