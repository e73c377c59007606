"""A model with the parameters left out that follow from the others: what is left to search for."""

from typing import final

import numpy as np

from robolaser.arrays import Array
from robolaser.model.forward_model import Model
from robolaser.model.stages import Stage

AT_ONCE = 400_000  # candidates times rows: some tens of megabytes
BREAKS_SCALE = (Stage.LIGHT, Stage.MOUNT)  # with effects here points do not grow with the baseline alone


@final
class Reduction:
    """Of a stripe scanner's fourteen there remain camera and tilt of the sheet, six numbers with the focal length held.

    Of a tracker and of sockets none remain. Numbers of effects come on top.

    Attributes:
        model: The whole.
        parameters: What remains.
    """

    def __init__(self, model: Model) -> None:
        sensor = model.sensor
        self.model = model
        self.parameters = model.parameters.without((*sensor.eliminated, *sensor.fixed))
        self._rounds = (
            2 if any(candidate_effect.effect.stage in BREAKS_SCALE for candidate_effect in model.effects) else 1
        )

    def completed(self, x: Array) -> Array:
        """Candidates (c, len(parameters)) as candidates of the whole model (c, d).

        The others are the best for them within their bounds; those that the gauge holds are at their nominal values.
        """
        parts = max(1, -(-len(x) * len(self.model.dataset.points) // AT_ONCE))
        return np.concatenate([self._completed(part) for part in np.array_split(x, parts)])

    def _completed(self, x: Array) -> Array:
        model, whole = self.model, self.model.parameters
        held = dict(zip(whole.names, np.tile(whole.nominal, (len(x), 1)).T, strict=True))
        values = {name: held[name] for name in model.sensor.fixed} | dict(self.parameters.values(x))
        perturb = model.perturb(values)
        T_base_flange = model.flange(values, perturb)
        for _ in range(self._rounds):
            values |= model.sensor.complete(values, T_base_flange, perturb, whole)
        stacked = np.stack([np.broadcast_to(values[name], len(x)) for name in whole.names], axis=-1)
        return np.asarray(np.clip(stacked, whole.lower, whole.upper))
