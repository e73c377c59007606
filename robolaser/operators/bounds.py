"""The bounds of variables, for an operator's steps, and of its settings."""

from typing import Any

import numpy as np

from robolaser.arrays import Array
from robolaser.errors import AlgorithmError


def finite_bounds(problem: Any, operator: str) -> tuple[Array, Array]:
    """Lower and upper bounds of a problem's variables, (d,) each; an `AlgorithmError` if they are not finite."""
    none = np.full(problem.n_var, np.nan)
    lower, upper = (none if x is None else np.asarray(x, np.float64) for x in (problem.xl, problem.xu))
    open_ended = np.flatnonzero(~(np.isfinite(lower) & np.isfinite(upper)))
    if len(open_ended):
        raise AlgorithmError(
            f"{operator} measures its steps by the distance to the bounds, but the problem gives variables"
            f" {', '.join(map(str, open_ended))} no finite ones. Give the problem finite xl and xu."
        )
    return lower, upper


def check_share(owner: str, setting: str, value: Any) -> None:
    """Raise an `AlgorithmError` if a number is no share; None, functions and pymoo's variables are not checked."""
    if isinstance(value, (int, float)) and not 0.0 <= value <= 1.0:
        raise AlgorithmError(f"{owner}: {setting} is {value!r}, expected a number from 0 to 1.")
