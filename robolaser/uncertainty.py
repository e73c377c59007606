"""How well a calibration is known: standard errors, and the parameters that the data cannot tell apart."""

from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from typing import final

import numpy as np

from robolaser.arrays import Array, Bools
from robolaser.noise import NoiseModel

NULL = 1e-7
"""Singular values of the Jacobian, its columns of unit length, below this share of the largest are zero.

Its numerical derivatives are exact to about 1e-10; the weakest real direction seen on 25 points is at 1e-5.
"""
LOADING = 1e-4
"""Share of the largest move of a residual from which on a parameter takes part in a null direction: ten times above
what the numerical error of the direction can be."""
WEAK = 1.0 / np.sqrt(12.0)
"""Standard deviation of a direction, in units of the bounds' width, from which on the data tell no more than the
bounds: that of anything between them alike."""
WEAK_LOADING = 0.2
"""Share of the largest, in units of the bounds' width, from which on a parameter takes part in a weak direction."""


@final
@dataclass(frozen=True)
class Unidentifiable:
    """Parameters that these data cannot tell apart, or not tell at all.

    Attributes:
        parameters: Their names, in the model's order.
        reason: A sentence for a person.
    """

    parameters: tuple[str, ...]
    reason: str


def covariance(J: Array, noise: NoiseModel, *, weighted: bool) -> Array:
    """Covariance of the fitted parameters, whatever the plain fit took for granted.

    Plain least squares weighs all rows alike, which they are not: (JᵀJ)⁻¹ JᵀΣJ (JᵀJ)⁻¹. Weighted by the noise it is
    (JᵀΣ⁻¹J)⁻¹. Inverses leave null directions out, so parameters that take part in one seem exact here: see
    `standard_errors`.

    Args:
        J: Plain residuals by the parameters that were free, (3m, d).
        noise: Of the residuals.
        weighted: Whether the fit minimised the whitened residuals.

    Returns:
        (d, d).
    """
    if weighted:
        J = noise.whiten(J.T).T
    scale = _lengths(J)
    unit = J / scale
    _, s, Vt = np.linalg.svd(unit, full_matrices=False)
    real = s > NULL * s.max(initial=0.0)
    inverse = (Vt[real].T / s[real] ** 2) @ Vt[real]
    between = inverse if weighted else inverse @ noise.seen_through(unit) @ inverse
    found: Array = between / scale / scale[:, None]
    return found


def standard_errors(J: Array, noise: NoiseModel, *, held: Bools, weighted: bool) -> Array:
    """One standard deviation of each parameter, the held ones taken as known, (d,).

    Args:
        J: Plain residuals by all parameters, (3m, d).
        noise: Of the residuals.
        held: Parameters that were not free: by the gauge, or because they ended on a bound, (d,).
        weighted: Whether the fit minimised the whitened residuals.

    Returns:
        NaN for the held ones and for all that take part in a null direction of the rest.
    """
    free = np.flatnonzero(~held)
    std = np.full(J.shape[1], np.nan)
    std[free] = np.sqrt(np.diag(covariance(J[:, free], noise, weighted=weighted)))
    for direction in null_directions(J[:, free]):
        std[free[direction != 0.0]] = np.nan
    return std


def null_directions(J: Array) -> Array:
    """Directions of the parameters that move no residual, with as few parameters each as can be.

    The basis of the null space is brought to reduced echelon form: of the parameters one direction leads with, the
    others have none, and directions that share no parameter come out apart.

    Args:
        J: Residuals by parameters, (k, d).

    Returns:
        (n, d), exactly zero for parameters that do not take part, in units of the parameters.
    """
    scale = _lengths(J)
    _, s, Vt = np.linalg.svd(J / scale, full_matrices=len(J) < J.shape[1])
    s = np.concatenate([s, np.zeros(len(Vt) - len(s))])
    basis = Vt[s <= NULL * s.max(initial=0.0)]
    for lead in range(len(basis)):
        row, column = np.unravel_index(np.argmax(np.abs(basis[lead:])), basis[lead:].shape)
        basis[[lead, lead + row]] = basis[[lead + row, lead]]
        basis[lead] /= basis[lead, column]
        others = np.arange(len(basis)) != lead
        basis[others] -= basis[others, column : column + 1] * basis[lead]
    share = np.abs(basis) / np.abs(basis).max(axis=1, keepdims=True, initial=np.finfo(float).tiny)
    return np.where(share > LOADING, basis, 0.0) / scale


def unidentifiable(
    J: Array,
    names: Sequence[str],
    width: Array,
    noise: NoiseModel,
    *,
    on_bound: Bools | None = None,
    weighted: bool = False,
) -> list[Unidentifiable]:
    """What the data cannot tell: null directions first, then those that they fix no better than the bounds do.

    Args:
        J: Plain residuals by all parameters, those held by a gauge too, (3m, d).
        names: Of the parameters.
        width: Distance between the bounds of each, (d,).
        noise: Of the residuals.
        on_bound: Parameters that ended on a bound and count as known in the weak directions, (d,).
        weighted: Whether the fit minimised the whitened residuals.
    """
    found, free = [], np.ones(len(names), dtype=bool) if on_bound is None else ~on_bound
    involved = null_directions(J) != 0.0
    for direction in involved:
        found.append(_null([name for name, part in zip(names, direction, strict=True) if part]))
        free[np.flatnonzero(direction & (involved.sum(axis=0) == 1))[0]] = False  # known, it fixes this direction
    columns = np.flatnonzero(free)
    spread = covariance(J[:, columns], noise, weighted=weighted) / width[columns] / width[columns][:, None]
    std = np.sqrt(np.diag(spread)) * width[columns]
    variances, directions = np.linalg.eigh(spread)
    for variance, direction in zip(variances[::-1], directions.T[::-1], strict=True):
        if variance >= WEAK**2:
            parts = columns[np.abs(direction) > WEAK_LOADING * np.abs(direction).max()]
            errors = std[np.searchsorted(columns, parts)]
            found.append(_weak([names[i] for i in parts], errors, width[parts], float(np.sqrt(variance))))
    return found


def _null(names: list[str]) -> Unidentifiable:
    if len(names) == 1:
        return Unidentifiable(tuple(names), f"{names[0]} moves no predicted point of these data.")
    return Unidentifiable(
        tuple(names),
        f"{_listed(names)} can change together without moving any predicted point of these data: each is known only "
        "if another is held.",
    )


def _weak(names: list[str], std: Array, width: Array, spread: float) -> Unidentifiable:
    of_each = [f"{name} ± {s:.2g} within bounds {w:.2g} apart" for name, s, w in zip(names, std, width, strict=True)]
    what = names[0] if len(names) == 1 else f"a combination of {_listed(names)}"
    return Unidentifiable(
        tuple(names),
        f"These data fix {what} no better than the bounds do: its standard error is {spread:.2g} of the bounds' "
        f"width ({', '.join(of_each)}, SI). More poses that differ, above all in tilt and distance, would.",
    )


def _listed(names: Iterable[str]) -> str:
    *first, last = names
    return f"{', '.join(first)} and {last}" if first else last


def _lengths(J: Array) -> Array:
    """Length of each column, (d,); 1 for a column of zeros."""
    lengths = np.linalg.norm(J, axis=0)
    return np.where(lengths > 0.0, lengths, 1.0)
