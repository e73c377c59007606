"""Derivatives of the forward model's residuals: its effects and its sensors run on duals."""

from typing import Any, cast

import numpy as np

from robolaser.arrays import Array
from robolaser.duals import Dual
from robolaser.model.blocks.errors import in_six_ways
from robolaser.model.forward_model import Model
from robolaser.parameters import Values

WAYS = 6  # in which a flange can move


def jacobian(model: Model, x: Array) -> Array:
    """Derivatives of the residuals at candidates (c, d) by all parameters, (c, d, m, k), in their unit per unit."""
    count = x.shape[1]
    values = {name: Dual.parameter(x[:, i], i) for i, name in enumerate(model.parameters.names)}
    flange: Any = model.flange(cast("Values", values), only_seen=True)
    if not isinstance(flange, Dual) or len(flange.of) <= WAYS:
        return _by_numbers(model, values, flange, count)
    # however many parameters move joints and links, they move the flange in six ways, and each row by that of its pose
    J = _by_numbers(model, values, in_six_ways(flange.value, np.zeros(3), count), count + WAYS)
    moves = np.moveaxis(_twists(flange), 0, -1)[:, model.dataset.points.pose]
    by_way = np.moveaxis(J[:, count:], 1, -1)
    J = J[:, :count].copy()
    J[:, np.array(flange.of)] += np.moveaxis(by_way @ moves, -1, 1)
    return J


def _by_numbers(model: Model, values: dict[str, Dual], flange: Array | Dual, count: int) -> Array:
    """Derivatives of the residuals by all numbers below a count, (c, count, m, k)."""
    at = cast("Values", values)
    residuals: Any = model.blocks.residuals(at, cast("Array", flange), model.perturb(at))
    first = next(iter(values.values()))
    J = np.zeros((len(first), count, *residuals.shape[1:]))
    if isinstance(residuals, Dual):
        J[:, list(residuals.of)] = np.swapaxes(residuals.slopes, 0, 1)
    return J


def _twists(flange: Dual) -> Array:
    """Shifts of what is at the base's origin, and turns, by each parameter that moves the flange, (q, c, n, 6)."""
    T, slopes = flange.value, flange.slopes
    x, y, z, shift = T[..., 0, :3], T[..., 1, :3], T[..., 2, :3], slopes[..., :3, 3]
    turn = np.stack(
        [np.einsum("qcni,cni->qcn", slopes[..., row, :3], by) for row, by in ((2, y), (0, z), (1, x))], axis=-1
    )
    return np.concatenate([shift - np.cross(turn, T[..., :3, 3]), turn], axis=-1)


def jacobian_matrix(model: Model, x: Array) -> Array:
    """The same at one candidate (d,), for all numbers of all rows, (m k, d)."""
    J = jacobian(model, x[None])[0]
    return np.asarray(J.reshape(len(J), -1).T)
