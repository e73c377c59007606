"""Partial derivatives of NumPy's functions of numbers."""

from collections.abc import Callable
from typing import Any

import numpy as np

from robolaser.arrays import Array


def _one(value: Array, *at: Array) -> None:
    """A partial derivative that is 1, returned as None so that nothing is multiplied."""
    return


PARTIALS: dict[np.ufunc, tuple[Callable[..., Any], ...]] = {
    np.add: (_one, _one),
    np.subtract: (_one, lambda *_: -1.0),
    np.multiply: (lambda _, a, b: b, lambda _, a, b: a),
    np.divide: (lambda _, a, b: 1.0 / b, lambda v, a, b: -v / b),
    np.negative: (lambda *_: -1.0,),
    np.positive: (_one,),
    np.absolute: (lambda _, a: np.sign(a),),
    np.square: (lambda _, a: 2.0 * a,),
    np.sqrt: (lambda v, _: 0.5 / v,),
    np.power: (lambda _, a, b: b * a ** (b - 1.0), lambda v, a, b: v * np.log(a)),
    np.exp: (lambda v, _: v,),
    np.expm1: (lambda v, _: v + 1.0,),
    np.log: (lambda _, a: 1.0 / a,),
    np.sin: (lambda _, a: np.cos(a),),
    np.cos: (lambda _, a: -np.sin(a),),
    np.tan: (lambda v, _: 1.0 + v * v,),
    np.arcsin: (lambda _, a: 1.0 / np.sqrt(1.0 - a * a),),
    np.arccos: (lambda _, a: -1.0 / np.sqrt(1.0 - a * a),),
    np.arctan: (lambda _, a: 1.0 / (1.0 + a * a),),
    np.arctan2: (lambda _, a, b: b / (a * a + b * b), lambda _, a, b: -a / (a * a + b * b)),
    np.hypot: (lambda v, a, b: a / v, lambda v, a, b: b / v),
    np.maximum: (lambda _, a, b: a >= b, lambda _, a, b: a < b),
    np.minimum: (lambda _, a, b: a <= b, lambda _, a, b: a > b),
}
"""Partial derivatives of each function by its arguments, from its value and its arguments; None means 1."""
