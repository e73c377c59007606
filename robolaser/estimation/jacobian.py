"""How the residuals move with the parameters: derivatives exact enough to tell a null direction from a weak one."""

import numpy as np

from robolaser.arrays import Array
from robolaser.model.forward_model import Model

STEP = 1e-4
"""Of a parameter's width: with the fourth-order rule below, truncation and rounding are both near 1e-11."""

_AT = np.array([-2.0, -1.0, 1.0, 2.0])
_WEIGHT = np.array([1.0, -8.0, 8.0, -1.0]) / 12.0


def jacobian(model: Model, x: Array) -> Array:
    """Derivative of the residuals with respect to every parameter, at x (d,).

    Args:
        model: Gives residuals in the order of its rows, three to a row.
        x: One candidate in the order of `model.parameters`, (d,).

    Returns:
        (3m, d), a column in metres per unit of its parameter. Central differences of fourth order; parameters of which
        no row depends on more than one are moved together (Curtis, Powell, Reid 1974).
    """
    parameters, groups = model.parameters, model.sensor.separable
    step, m = STEP * parameters.width, len(model.dataset.points)
    together = {name for names, _ in groups for name in names}
    seen = {*model.sensor.free, *model.sensor.derived, *model.effect_parameters.names} - together
    alone = [column for column, name in enumerate(parameters.names) if name in seen]
    lots = [parameters.columns(names) for names, _ in groups]
    ways = np.zeros((len(alone) + len(lots), len(x)))
    for number, moving in enumerate([[column] for column in alone] + lots):
        ways[number, moving] = step[moving]

    moved = x + (_AT[:, None, None] * ways).reshape(-1, len(x))
    e = model.residuals(moved).reshape(4, len(ways), m, 3)
    changes = np.einsum("s,swma->maw", _WEIGHT, e)
    slopes = np.zeros((m, 3, len(x)))
    slopes[..., alone] = changes[..., : len(alone)] / step[alone]
    for number, (lot, (_, of_row)) in enumerate(zip(lots, groups, strict=True), start=len(alone)):
        own = np.array(lot)[of_row]
        slopes[np.arange(m), :, own] = changes[..., number] / step[own, None]
    return slopes.reshape(3 * m, -1)
