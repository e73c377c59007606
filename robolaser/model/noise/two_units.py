"""Rows that hold lengths and angles: what makes a metre and a radian comparable where nobody asks for weights."""

import numpy as np

from robolaser.arrays import Array
from robolaser.model.blocks.errors import row_errors
from robolaser.model.forward_model import Model
from robolaser.model.noise.covariance import FLOOR, NoiseModel


def comparable(model: Model, x: Array) -> NoiseModel | None:
    """Weights of rows in two units by the size of each one's errors; None where all numbers of a row are lengths.

    Sizes are those stated, else the median of the residuals' numbers at x.

    Args:
        model: Data and effects.
        x: Parameters near the optimum, (d,).
    """
    if not any(angles for *_, angles in model.blocks.kinds_of_rows.values()):
        return None
    values = model.parameters.values(x[None])
    perturb = model.perturb(values)
    sources = row_errors(model.blocks, values, model.flange(values, perturb), perturb)
    residuals = model.residuals_at(values)[0]
    sigmas = {}
    for source in sources:
        moved = (source.effect**2).sum(axis=(1, 2)) > 0.0  # others are another sensor's
        sigmas[source.name] = source.stated or max(size_of_errors(source.effect[moved], residuals[moved]), FLOOR)
    return NoiseModel(sources, sigmas, relative=True)


def size_of_errors(effect: Array, residuals: Array) -> float:
    """Median over rows of the least unit errors that explain them, root mean square; 0 where there are no rows.

    Args:
        effect: Moves of each row's numbers by each of q unit errors, (m, k, q).
        residuals: (m, k).
    """
    errors = (np.linalg.pinv(effect) @ residuals[..., None])[..., 0]
    sizes = np.linalg.norm(errors, axis=1) / np.sqrt(np.maximum(np.linalg.matrix_rank(effect), 1))
    return float(np.median(sizes)) if len(sizes) else 0.0
