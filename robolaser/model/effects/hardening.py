"""What yields less and less, or more and more, the more it is loaded."""

from dataclasses import replace

import numpy as np

from robolaser.arrays import Array
from robolaser.model.effects.effect import CarryOver, Effect


def hardened(deflection: Array, reference: Array, hardening: Array) -> Array:
    """Deflections d (c, n, k) as d (1 - hardening |d| / max |d|); below zero what yields softens.

    Args:
        deflection: Of what yields in proportion to its load, in k directions.
        reference: The same at the poses that were calibrated, (c, m, k), whose largest counts.
        hardening: Of each candidate, (c,).
    """
    most = np.linalg.norm(reference, axis=2).max(axis=1)[:, None, None]
    share = np.linalg.norm(deflection, axis=2, keepdims=True) / np.where(most > 0.0, most, 1.0)
    less: Array = deflection * (1.0 - hardening[:, None, None] * share)
    return less


def with_hardening(carried: CarryOver, hardening: Array, unhardened: Effect) -> CarryOver:
    """What becomes of an effect that hardens in another run, whose largest load is another one."""
    if carried.effect is None or not hardening.any():
        return carried
    doubt = "its hardening is relative to the largest load of the poses, which differ from the calibrated ones"
    return replace(carried, doubt=doubt, alternatives=(unhardened,))
