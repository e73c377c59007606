"""How loops are compiled: without Python's lock, kept on disk from one run to the next."""

from collections.abc import Callable
from typing import Any

import numba

MADE_FREELY = {"contract", "reassoc"}
"""Sums may be taken in any order and products fused; what is not finite stays so."""


def compiled(function: Callable[..., Any]) -> Callable[..., Any]:
    """Compile a function of arrays and numbers."""
    made: Callable[..., Any] = numba.njit(
        cache=True, nogil=True, fastmath=MADE_FREELY, error_model="numpy", boundscheck=False
    )(function)
    return made
