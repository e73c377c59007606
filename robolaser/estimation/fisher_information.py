"""What a fit's own data say of its noise and of how well its parameters are known, a block of rows at a time."""

from collections.abc import Mapping
from functools import reduce
from operator import add

from robolaser.arrays import Array
from robolaser.estimation.gauss_newton import SQUARE
from robolaser.estimation.identifiability import Information
from robolaser.estimation.jacobian import jacobian
from robolaser.estimation.problem import Residuals
from robolaser.model.noise import NoiseModel
from robolaser.model.noise.sources import error_sources

UNMOVED_M = 1e-10  # a parameter whose whole range moves points by less only moves the last digits: a step's moment does


def information(residuals: Residuals, x: Array, sigmas: Mapping[str, float]) -> Information:
    """What all rows say of the parameters at the optimum.

    Args:
        residuals: Those that were minimised.
        x: The optimum, (d,).
        sigmas: Standard deviation of each source of noise.
    """
    known = reduce(add, (_of_block(block, x, sigmas) for _, block in residuals.blocks))
    return known.without(known.reach * residuals.model.parameters.width <= UNMOVED_M)


def _of_block(block: Residuals, x: Array, sigmas: Mapping[str, float]) -> Information:
    noise = NoiseModel(error_sources(block.model, x), sigmas)
    shares = None if block.loss == SQUARE else block.loss.shares(block(x[None]))[0]
    return Information.of(jacobian(block.model, x), noise, weights=block.noise, shares=shares)
