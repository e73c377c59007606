"""The bounds that an operator measures its steps by, and those of its own settings."""

from collections.abc import Iterable
from typing import Any

import numpy as np

from robolaser.arrays import Array
from robolaser.errors import AlgorithmError


def finite_bounds(problem: Any, operator: str) -> tuple[Array, Array]:
    """Lower and upper bounds of a problem's variables, (d,) each.

    Raises:
        AlgorithmError: A variable has no finite bounds.
    """
    if problem.xl is None or problem.xu is None:
        raise bounds_missing(operator, range(problem.n_var))
    lower, upper = np.asarray(problem.xl, np.float64), np.asarray(problem.xu, np.float64)
    open_ended = ~(np.isfinite(lower) & np.isfinite(upper))
    if open_ended.any():
        raise bounds_missing(operator, np.flatnonzero(open_ended))
    return lower, upper


def bounds_missing(operator: str, variables: Iterable[int]) -> AlgorithmError:
    """Variables have no finite bounds, but step sizes are relative to them."""
    return AlgorithmError(
        f"{operator} measures its steps by the distance to the bounds, but the problem gives variables"
        f" {', '.join(map(str, variables))} no finite ones. Give the problem finite xl and xu."
    )


def check_probability(owner: str, setting: str, value: Any) -> None:
    """Refuse a number that is no probability; None and pymoo's variables stand for numbers that come later.

    Raises:
        AlgorithmError: It is below 0 or above 1.
    """
    if isinstance(value, (int, float)) and not 0.0 <= value <= 1.0:
        raise AlgorithmError(f"{owner}: {setting} is {value!r}, expected a probability, 0 to 1.")
