"""The uncertainty of a calibration: standard errors, and the parameters that the data cannot identify."""

from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from itertools import combinations
from typing import final

import numpy as np

from robolaser.arrays import Array, Bools
from robolaser.estimation.fisher_information import NULL, Information, lengths

LOADING = 1e-4
"""Share of the largest move of a residual above which a parameter takes part in a null direction: ten times the
largest numerical error of the direction."""
FEW = 3  # null directions, up to which all choices of pivots are tried
STEADY = 1e-3  # smallest singular value of the pivot block, so that dividing by it magnifies no numerical error
WEAK_LOADING = 0.2
"""Share of the largest, in units of the bounds' width, above which a parameter takes part in a weak direction."""

UNIFORM = 12**-0.5
"""Standard deviation of a uniform distribution over its width. Above it, the data on a direction, in units of the
bounds' width, add nothing to the bounds."""


@final
@dataclass(frozen=True)
class Unidentifiable:
    """Parameters that these data cannot identify, alone or together."""

    parameters: tuple[str, ...]  # their names, in the model's order
    reason: str  # a sentence for the user


def standard_errors(known: Information, *, fixed: Bools, bounded: Array | None = None) -> Array:
    """One standard deviation of each parameter, the fixed ones taken as known, (d,).

    A parameter that ended on a bound has no meaningful standard error, but it is not known either: taken as known, it
    would make the others' standard errors far too small. For them its uncertainty is the one without bounds, or that of
    a uniform distribution within its bounds, whichever is less.

    Args:
        known: The information of all rows, known distances included.
        fixed: Parameters fixed by convention, as by a gauge, (d,).
        bounded: Distance between the bounds of each parameter that ended on one of them, zero for the rest, (d,).

    Returns:
        NaN for fixed parameters, for those on a bound and for all that take part in a null direction of the rest.
    """
    bounded = np.zeros(len(fixed)) if bounded is None else bounded
    on_bound, indices = bounded > 0, np.flatnonzero(~fixed)
    free = np.flatnonzero(~fixed & ~on_bound)
    null = indices[(null_directions(known.plain[:, indices]) != 0.0).any(axis=0)]
    spread = bounded * UNIFORM
    if on_bound.any():
        by_data = np.full(len(fixed), np.inf)
        by_data[indices] = np.sqrt(known.variances(indices))
        by_data[null] = np.inf
        spread = np.minimum(spread, by_data)
    cross = known.weighed[:, free].T @ known.weighed[:, on_bound]
    of_bounded = known.inverse(free) @ cross * spread[on_bound]
    std = np.full(len(fixed), np.nan)
    std[free] = np.sqrt(known.variances(free) + (of_bounded**2).sum(axis=1))
    std[null] = np.nan
    return std


def null_directions(J: Array) -> Array:
    """Directions of the parameters that move no residual, with as few parameters each as can be.

    A basis of the null space is brought to reduced echelon form: the pivot of each direction has no part in the others.
    Directions that share no parameter are separated whatever the pivots; where they overlap, the form with the fewest
    nonzero entries is taken.

    Returns:
        Of J (k, d) or its R factor, (n, d), exactly zero for parameters that do not take part, in their units.
    """
    scale = lengths(J)
    _, s, Vt = np.linalg.svd(J / scale, full_matrices=len(J) < J.shape[1])
    s = np.concatenate([s, np.zeros(len(Vt) - len(s))])
    basis = _echelon(Vt[s <= NULL * s.max(initial=0.0)])
    n = len(basis)
    if 2 <= n <= FEW:
        involved = np.flatnonzero(_thin(basis).any(axis=0)).tolist()
        leads = np.array(list(combinations(involved, n)))
        blocks = np.moveaxis(basis[:, leads], 1, 0)
        steady = np.linalg.svd(blocks, compute_uv=False)[:, -1] > STEADY
        forms = _thin(np.linalg.inv(blocks[steady]) @ basis)
        basis = forms[np.argmin((forms != 0.0).sum(axis=(1, 2)))]
    return _thin(basis) / scale


def unidentifiable(
    known: Information, names: Sequence[str], width: Array, *, stated: Bools | None = None
) -> list[Unidentifiable]:
    """Unidentifiable parameters: null directions first, then those that the data determine no better than the bounds.

    Args:
        known: The information of all rows about all parameters, those fixed by a gauge included.
        names: Of the parameters.
        width: Distance between the bounds of each, (d,).
        stated: Parameters that the data set fixes, (d,): not tested.
    """
    found, free = [], np.ones(len(names), dtype=bool) if stated is None else ~stated
    indices = np.flatnonzero(free)
    null = null_directions(known.plain[:, indices])
    involved = np.zeros((len(null), len(names)), dtype=bool)
    involved[:, indices] = null != 0.0
    for direction in involved:
        found.append(_null([name for name, part in zip(names, direction, strict=True) if part]))
        free[np.flatnonzero(direction & (involved.sum(axis=0) == 1))[0]] = False  # once known, it fixes the direction
    columns = np.flatnonzero(free)
    spread = known.covariance(columns) / width[columns] / width[columns][:, None]
    variances, directions = np.linalg.eigh(spread)
    for variance, direction in zip(variances[::-1], directions.T[::-1], strict=True):
        if variance >= UNIFORM**2:
            parts = columns[np.abs(direction) > WEAK_LOADING * np.abs(direction).max()]
            found.append(_weak([names[i] for i in parts], float(np.sqrt(variance))))
    return found


def _null(names: list[str]) -> Unidentifiable:
    if len(names) == 1:
        return Unidentifiable(tuple(names), f"{names[0]} moves no predicted point of these data.")
    return Unidentifiable(
        tuple(names),
        f"{_listed(names)} can change together without moving any predicted point of these data: each is known only "
        "if another is fixed.",
    )


def _weak(names: list[str], spread: float) -> Unidentifiable:
    what = names[0] if len(names) == 1 else f"a combination of {_listed(names)}"
    return Unidentifiable(
        tuple(names),
        f"These data determine {what} no better than the bounds do: its standard error is {spread:.2g} times the "
        "distance between the bounds.",
    )


def _listed(names: Iterable[str]) -> str:
    *first, last = names
    return f"{', '.join(first)} and {last}" if first else last


def _echelon(basis: Array) -> Array:
    """Gauss-Jordan elimination with the largest entries as pivots."""
    basis = basis.copy()
    for lead in range(len(basis)):
        row, column = divmod(int(np.argmax(np.abs(basis[lead:]))), basis.shape[1])
        basis[[lead, lead + row]] = basis[[lead + row, lead]]
        basis[lead] /= basis[lead, column]
        others = np.arange(len(basis)) != lead
        basis[others] -= basis[others, column : column + 1] * basis[lead]
    return basis


def _thin(basis: Array) -> Array:
    """With exact zeros for the parameters that take no part, (..., n, d)."""
    largest = np.abs(basis).max(axis=-1, keepdims=True, initial=np.finfo(float).tiny)
    return np.where(np.abs(basis) > LOADING * largest, basis, 0.0)
