"""Derivatives of the forward model's residuals: analytic where the sensor has them, else central differences."""

import numpy as np

from robolaser.arrays import Array
from robolaser.finite_differences import differences
from robolaser.model.forward_model import Model
from robolaser.model.stages import Stage
from robolaser.model.tangents import ChainRule, Tangent
from robolaser.robot.flange_motion import moved_by_twists

STEP = 1e-5
"""Of a central difference, in units of a parameter's range: truncation and rounding are both near 1e-10 there."""

SIX_WAYS = np.eye(6)[None, :, None]
"""The flange's unit twists, (1, 6, 1, 6)."""


def jacobian(model: Model, x: Array) -> Array:
    """Derivatives of the residuals by all parameters.

    By the sensor's own parameters as it knows them; by the others, such as those of effects, by the chain rule, or
    numerically where the sensor does not know how its rows move.

    Args:
        model: With its effects.
        x: Candidates in the order of `model.parameters`, (c, d).

    Returns:
        (c, d, m, k), in the residuals' unit per unit of each parameter.
    """
    values = model.parameters.values(x)
    perturb = model.perturb(values)
    known = model.sensor.jacobian(values, model.flange(values, perturb), perturb)
    names = model.sensor.free + model.sensor.derived
    if known is not None and names == model.parameters.names:
        return np.require(np.moveaxis(known, -1, 1), requirements=["C", "W"])
    steps = STEP * model.parameters.width
    chain = model.chain_rule(x, steps)
    J = _by_stages(model, chain)
    analytic = 0 if known is None else x.shape[1] - len(model.effect_parameters)
    if J is None:
        J = _differences(model, x, steps, analytic)
    if known is not None:
        J[:, model.parameters.columns(names)] = np.moveaxis(known, -1, 1)
    return J


def _by_stages(model: Model, chain: ChainRule) -> Array | None:
    """Derivatives by what moves the values that pass the stages, (c, d, m, k), where the sensor knows them.

    However many parameters move joints and links, they move the flange in six ways, and each row by that of its pose.
    """
    twists = model.flange_twists(chain)
    if twists is None or len(twists.of) <= SIX_WAYS.shape[1] or chain.moves(Stage.FLANGE, Stage.IMAGE):
        return model.sensor.slopes(model.flange_tangent(chain, twists), chain)
    some = twists.of[: SIX_WAYS.shape[1]]
    J = model.sensor.slopes(Tangent(twists.value, moved_by_twists(twists.value, SIX_WAYS), some), chain)
    if J is not None:
        moves = np.swapaxes(twists.slopes, 1, 2)[:, model.dataset.points.pose]
        J[:, twists.of] = np.swapaxes(moves @ np.swapaxes(J[:, some], 1, 2), 1, 2)
    return J


def _differences(model: Model, x: Array, steps: Array, first: int) -> Array:
    """Derivatives by the parameters from a number on, (c, d, m, k), zero by the others."""
    everywhere = np.full(x.shape[1], np.inf)

    def flat(candidates: Array) -> Array:
        return model.residuals(candidates).reshape(len(candidates), -1)

    slopes = differences(flat, x, steps, np.arange(first, x.shape[1]), -everywhere, everywhere)
    J = np.zeros((*x.shape, len(model.dataset.points), model.sensor.format.numbers))
    J[:, first:] = slopes.reshape(len(x), -1, *J.shape[2:])
    return J


def jacobian_matrix(model: Model, x: Array) -> Array:
    """The same at one candidate (d,), for all numbers of all rows, (m k, d)."""
    J = jacobian(model, x[None])[0]
    return np.asarray(J.reshape(len(J), -1).T)
