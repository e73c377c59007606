"""How well a calibration is known: standard errors, and the parameters that the data cannot tell apart."""

from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from typing import final

import numpy as np

from robolaser.arrays import Array, Bools
from robolaser.noise import NoiseModel
from robolaser.null_space import NULL, column_lengths, null_directions

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
    scale = column_lengths(J)
    unit = J / scale
    _, s, Vt = np.linalg.svd(unit, full_matrices=False)
    real = s > NULL * s.max(initial=0.0)
    inverse = (Vt[real].T / s[real] ** 2) @ Vt[real]
    between = inverse if weighted else inverse @ noise.seen_through(unit) @ inverse
    found: Array = between / scale / scale[:, None]
    return found


def standard_errors(
    J: Array, noise: NoiseModel, *, held: Bools, weighted: bool, on_bound: Bools | None = None
) -> Array:
    """One standard deviation of each parameter, the held ones taken as known, (d,).

    A parameter that ended on a bound has none that means anything, but is not known either: were it taken as known,
    the others would seem far surer than they are. So it counts as free for them.

    Args:
        J: Plain residuals by all parameters, (3m, d).
        noise: Of the residuals.
        held: Parameters whose values are a convention, as one of a gauge's is, (d,).
        weighted: Whether the fit minimised the whitened residuals.
        on_bound: Parameters that ended on a bound, (d,).

    Returns:
        NaN for the held ones, for those on a bound and for all that take part in a null direction of the rest.
    """
    free = np.flatnonzero(~held)
    std = np.full(J.shape[1], np.nan)
    std[free] = np.sqrt(np.diag(covariance(J[:, free], noise, weighted=weighted)))
    for direction in null_directions(J[:, free]):
        std[free[direction != 0.0]] = np.nan
    if on_bound is not None:
        std[on_bound] = np.nan
    return std


def unidentifiable(
    J: Array,
    names: Sequence[str],
    width: Array,
    noise: NoiseModel,
    *,
    weighted: bool = False,
) -> list[Unidentifiable]:
    """What the data cannot tell: null directions first, then those that they fix no better than the bounds do.

    Args:
        J: Plain residuals by all parameters, those held by a gauge too, (3m, d).
        names: Of the parameters.
        width: Distance between the bounds of each, (d,).
        noise: Of the residuals.
        weighted: Whether the fit minimised the whitened residuals.
    """
    found, free = [], np.ones(len(names), dtype=bool)
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
