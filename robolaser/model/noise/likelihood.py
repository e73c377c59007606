"""The likelihood of noise sizes given the residuals of a fit: all sizes from residuals are estimated here."""

from collections.abc import Collection, Mapping
from dataclasses import dataclass
from functools import cached_property
from typing import final

import numpy as np

from robolaser.arrays import Array, Bools, Ints
from robolaser.data.subsampling import some_of_each
from robolaser.model.error_source import ErrorSource
from robolaser.model.noise import reml
from robolaser.model.noise.covariance import FLOOR, NoiseModel, Origin

MOST_ROWS_A_POSE = 30  # more add nothing on the size of the errors
MOST_ROWS = 2000  # altogether, as long as each pose keeps a few
LEAST_ROWS_A_POSE = 3
Known = Mapping[str, tuple[float, Origin]]  # sizes of sources, and where they come from, by name
UNMOVED = 1e-12  # variance by a source, over the largest, up to which it does not move a number
FEW = 0.5  # share of a pose's numbers up to which it pays to separate the directions of its errors


@final
@dataclass(frozen=True, eq=False)
class PoseErrors:
    """Residuals of a fit at each pose, and their possible causes."""

    unit: Mapping[str, Array]  # covariance that a unit of each source causes, (n, s, s) by name
    floor: Array  # covariance without any, regular, (n, s, s)
    e: Array  # residuals, (n, s)
    Q: Array  # a basis of their changes by the fitted numbers, (n, s, d)
    times: Array  # multiplicity of each pose, (n,)


@final
@dataclass(frozen=True, eq=False)
class NoiseLikelihood:
    """The likelihood of the sources' sizes given the residuals of a fit."""

    sources: tuple[ErrorSource, ...]  # of the rows' errors
    of_pose: Ints  # pose of each row, (m,)
    residuals: Array  # residuals of the fit, (m, k) [row's unit]
    J: Array  # derivatives of the residuals by the fitted parameters, (m k, d)

    def likeliest(self, known: Known, least: Mapping[str, float] | None = None) -> tuple[NoiseModel, float]:
        """The noise with the known sizes (see `known_sizes`), and the likeliest others.

        Args:
            known: By name.
            least: Lower limits of others, by name; their source's when absent. Sources that move no row are that large.

        Returns:
            The noise, and the negative log of the restricted likelihood, up to a constant of the rows.
        """
        sigmas, cost = {source.name: (least or {}).get(source.name, source.least) for source in self.sources}, 0.0
        sigmas |= {name: size for name, (size, _) in known.items()}
        unknown = [source for source in self.sources if source.name not in known]
        if unknown := [source for source in unknown if self._errors.unit[source.name].any()]:
            low = np.array([sigmas[source.name] for source in unknown])
            high = np.array([source.most for source in unknown])
            errors = self._errors
            known_covariance = sum((size**2 * errors.unit[name] for name, (size, _) in known.items()), errors.floor)
            unit = [errors.unit[source.name] for source in unknown]
            found, cost = reml.estimate(known_covariance, unit, errors.e, errors.Q, low, high, errors.times)
            sigmas |= dict(zip([source.name for source in unknown], found.tolist(), strict=True))
        names = [source.name for source in self.sources]
        origin: dict[str, Origin] = {name: known[name][1] if name in known else "estimated" for name in names}
        return NoiseModel(self.sources, {name: sigmas[name] for name in names}, origin), cost

    def gain_of_growth(self, noise: NoiseModel, names: Collection[str]) -> float:
        """Increase of the largest log-likelihood if named sources grew: a score test."""
        shaking, (_, expected, there, curvature) = self._restricted(noise)
        tried = np.isin(shaking, list(names))
        slope = np.where(tried, there - expected, 0.0)
        free = ~tried | (slope > 0.0)
        return 0.5 * float(slope[free] @ np.linalg.lstsq(curvature[np.ix_(free, free)], slope[free])[0])

    def cost(self, noise: NoiseModel) -> tuple[float, dict[str, float]]:
        """The negative log of the restricted likelihood of some noise, and the relative error of each size by name.

        The value is up to a constant of the rows; the errors are standard deviations of the sizes' logarithms.
        """
        shaking, (value, _, _, curvature) = self._restricted(noise)
        errors = np.sqrt(np.maximum(np.diag(np.linalg.pinv(curvature)), 0.0))
        return value, dict(zip(shaking, errors.tolist(), strict=True))

    def _restricted(self, noise: NoiseModel) -> tuple[list[str], tuple[float, Array, Array, Array]]:
        """Names of the active sources, and `reml.restricted` of their sizes."""
        shaking = {name: size for name, size in noise.sigmas.items() if size > 0.0}
        errors, log_sigma = self._errors, np.log(list(shaking.values()))
        unit = [errors.unit[name] for name in shaking]
        return list(shaking), reml.restricted(log_sigma, errors.floor, unit, errors.e, errors.Q, errors.times)

    @cached_property
    def _table(self) -> Ints:
        """Rows of each pose that count, (n, r); -1 where a pose has fewer."""
        most = MOST_ROWS // len(np.unique(self.of_pose))
        return some_of_each(self.of_pose, int(np.clip(most, LEAST_ROWS_A_POSE, MOST_ROWS_A_POSE)))

    @cached_property
    def _is_row(self) -> Bools:
        """Whether a pose has this number, (n, s)."""
        return np.repeat(self._table >= 0, self.residuals.shape[-1], axis=1)

    @cached_property
    def _errors(self) -> PoseErrors:
        """The residuals of each pose, and their possible causes."""
        k = self.residuals.shape[-1]
        columns = (k * self._table[:, :, None] + np.arange(k)).reshape(self._is_row.shape)
        e = np.where(self._is_row, self.residuals.reshape(-1)[columns], 0.0)
        Q = reml.basis(np.where(self._is_row[..., None], self.J[columns], 0.0))
        unit = {source.name: reml.blocks(source.effect, source.group, self._table) for source in self.sources}
        floor = np.eye(self._is_row.shape[1]) * np.where(self._is_row, FLOOR**2, 1.0)[:, None]
        return condensed(PoseErrors(unit, floor, e, Q, np.ones(len(e))), self._is_row)


def condensed(errors: PoseErrors, is_row: Bools) -> PoseErrors:
    """The same likelihood, up to a constant, of fewer numbers; all of them where separation gains little.

    Errors of whole poses move all rows of a pose together, in a few directions. In all others there are only equal and
    independent errors of rows, such as pixel noise: these directions may be rotated among each other, over all poses,
    until only as many as there are fitted numbers are nonzero. The rest is counted.

    `is_row` is whether a pose has this number, (n, s): others have no residual, and a floor of one.
    """
    n, s = is_row.shape
    own = {name: size for name, C in errors.unit.items() if (size := _alike(C, is_row)) is not None}
    moved = sum((C / C.max() for name, C in errors.unit.items() if name not in own and C.any()), np.zeros((n, s, s)))
    shaken, U = np.linalg.eigh(moved - np.eye(s) * ~is_row[:, None])  # ascending: numbers that no pose has come first
    q = int((shaken > UNMOVED * shaken.max()).sum(axis=1).max())
    if not 0 < q <= FEW * s:
        return errors
    apart, alike = U[..., s - q :], U[..., : s - q]
    rows = np.concatenate([errors.Q, errors.e[..., None]], axis=2)
    _, R = np.linalg.qr((np.swapaxes(alike, 1, 2) @ rows).reshape(n * (s - q), -1))
    few = np.concatenate([R, np.zeros((-len(R) % q + q, R.shape[1]))]).reshape(-1, q, R.shape[1])
    others = (is_row.sum() - np.minimum(is_row.sum(axis=1), q).sum()) / q  # poses of q numbers
    if others < len(few):
        return errors
    rows = np.concatenate([np.swapaxes(apart, 1, 2) @ rows, few])

    def turned(C: Array, of_own: float) -> Array:
        rest = np.broadcast_to(of_own * np.eye(q), (len(few), q, q))
        return np.concatenate([np.swapaxes(apart, 1, 2) @ C @ apart, rest])

    times = np.ones(len(rows))
    times[-1] = 1.0 + others - len(few)
    unit = {name: turned(C, own.get(name, 0.0)) for name, C in errors.unit.items()}
    floor = turned(errors.floor, errors.floor[_diagonal(is_row)].min())
    return PoseErrors(unit, floor, rows[..., -1], rows[..., :-1], times)


def _diagonal(is_row: Bools) -> Bools:
    return is_row[:, :, None] & np.eye(is_row.shape[1], dtype=bool)


def _alike(C: Array, is_row: Bools) -> float | None:
    """Variance by a source that moves all numbers equally and independently; None for any other source."""
    size = float(C.max())
    return size if np.allclose(C, size * _diagonal(is_row), rtol=0.0, atol=UNMOVED * size) else None
