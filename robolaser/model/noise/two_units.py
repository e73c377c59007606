"""Rows that hold lengths and angles: what makes a metre and a radian comparable where nobody asks for weights."""

import numpy as np

from robolaser.arrays import Array
from robolaser.model.forward_model import Model
from robolaser.model.noise.covariance import FLOOR, NoiseModel


def comparable(model: Model, x: Array) -> NoiseModel | None:
    """Weights of rows in two units by the size of each one's errors; None where all numbers of a row are lengths.

    Sizes are those stated, else the median of the residuals' numbers at x.

    Args:
        model: Data and effects.
        x: Parameters near the optimum, (d,).
    """
    if not any(angles for *_, angles in model.sensor.kinds_of_rows.values()):
        return None
    values = model.parameters.values(x[None])
    perturb = model.perturb(values)
    sources = tuple(model.sensor.row_errors(values, model.flange(values, perturb), perturb))
    residuals = model.residuals_at(values)[0]
    sigmas = {}
    for source in sources:
        squares = (source.effect**2).sum(axis=1)
        moved = squares.min(axis=1) > 0.0  # others are another sensor's
        along = (np.swapaxes(source.effect, -1, -2) @ residuals[..., None])[moved, :, 0] / squares[moved]
        sigmas[source.name] = source.stated or max(float(np.median(np.abs(along))) if moved.any() else 0.0, FLOOR)
    return NoiseModel(sources, sigmas, relative=True)
