"""Compliance that decreases, or increases, with the load."""

from dataclasses import replace

import numpy as np

from robolaser.arrays import Array
from robolaser.model.effects.effect import CarryOver, Effect


def hardened(deflection: Array, reference: Array, hardening: Array) -> Array:
    """Deflections d (c, n, k) as d (1 - hardening |d| / max |d|); below zero they soften.

    Args:
        deflection: In proportion to the load, in k directions.
        reference: The same at the calibrated poses, (c, m, k), of which the largest counts.
        hardening: Of each candidate, (c,).
    """
    most = np.linalg.norm(reference, axis=2).max(axis=1)[:, None, None]
    share = np.linalg.norm(deflection, axis=2, keepdims=True) / np.where(most > 0.0, most, 1.0)
    less: Array = deflection * (1.0 - hardening[:, None, None] * share)
    return less


def with_hardening(carried: CarryOver, hardening: Array, unhardened: Effect) -> CarryOver:
    """A hardening effect in another run with another largest load."""
    if carried.effect is None or not hardening.any():
        return carried
    doubt = "its hardening is relative to the largest load of the poses, which differ from the calibrated ones"
    return replace(carried, doubt=doubt, alternatives=(unhardened,))
