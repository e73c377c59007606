"""The restricted likelihood of noise sizes given the residuals of a fit: all sizes from residuals are estimated here.

The d fitted numbers made the residuals smaller than the errors; the restricted likelihood uses only the combinations
of residuals that no fitted number can change. Patterson, Thompson 1971, Biometrika 58; Harville 1977.
"""

from collections.abc import Callable, Collection, Mapping, Sequence
from dataclasses import dataclass, replace
from functools import cached_property
from typing import final

import numpy as np

from robolaser.arrays import Array, Bools, Ints
from robolaser.data.subsampling import some_of_each
from robolaser.model.error_source import ErrorSource
from robolaser.model.noise.covariance import FLOOR, NoiseModel, Origin

MOST_ROWS_A_POSE = 30  # more add nothing on the size of the errors
MOST_ROWS = 2000  # altogether, as long as each pose keeps a few
LEAST_ROWS_A_POSE = 3
Known = Mapping[str, tuple[float, Origin]]  # sizes of sources, and where they come from, by name
TINY = float(np.finfo(np.float64).tiny)
UNMOVED = 1e-12  # variance by a source, over the largest, up to which it does not move a number
FEW = 0.5  # share of a pose's numbers up to which it pays to separate the directions of its errors
SPAN = (1e-4, 1e2)  # search range of a standard deviation, in units of the one that would explain the residuals alone
BEGINNING = 1e-2  # of a source that begins to grow, likewise
STARTS = (1.0, 0.1)
"""Starts of the search, in units of equal shares in the residuals: a single one may end in a local optimum."""
CALM_STEPS = 6
"""Steps that cannot overshoot (Zhou et al. 2019, J. Comput. Graph. Stat. 28), before Newton's: from afar these leap to
where a source vanishes, and there the slope vanishes too."""
MOST_STEPS, HALVINGS = 100, 30
TOGETHER = 0.1  # difference in logarithms of the standard deviations, below which two searches have converged to one
LONGEST_STEP = 2.0  # of Newton's step, in logarithms of a standard deviation
SUFFICIENT = 1e-4  # share of the slope's predicted gain that a step must reach (Armijo)
CONVERGED = 1e-3  # share of the negligible gain below which a step ends the search
ENOUGH = 1e-6
"""Of the likelihood's logarithm for each row and axis, and of its slope: negligible even for thousands of rows."""
RANK = 1e-9  # singular values of the Jacobian below this share of the largest belong to null directions


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
            found, cost = estimate(known_covariance, unit, errors.e, errors.Q, low, high, errors.times)
            sigmas |= dict(zip([source.name for source in unknown], found.tolist(), strict=True))
        names = [source.name for source in self.sources]
        origin: dict[str, Origin] = {name: known[name][1] if name in known else "estimated" for name in names}
        return NoiseModel(self.sources, {name: sigmas[name] for name in names}, origin), cost

    def gain_of_growth(self, noise: NoiseModel, names: Collection[str]) -> float:
        """Increase of the largest log-likelihood if named sources grew, also from zero: a score test."""
        errors, sizes = self._errors, dict(noise.sigmas)
        for name in names:
            alone = np.square(errors.e).sum() / max(np.einsum("n,nii->", errors.times, errors.unit[name]), TINY)
            sizes[name] = sizes.get(name) or BEGINNING * float(np.sqrt(alone))
        shaking, (_, expected, there, curvature) = self._restricted(replace(noise, sigmas=sizes))
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
        """Names of the active sources, and `restricted` of their sizes."""
        shaking = {name: size for name, size in noise.sigmas.items() if size > 0.0}
        errors, log_sigma = self._errors, np.log(list(shaking.values()))
        unit = [errors.unit[name] for name in shaking]
        return list(shaking), restricted(log_sigma, errors.floor, unit, errors.e, errors.Q, errors.times)

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
        Q = basis(np.where(self._is_row[..., None], self.J[columns], 0.0))
        unit = {source.name: covariance_of_unit(source.effect, source.group, self._table) for source in self.sources}
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


def covariance_of_unit(effect: Array, group: Ints, table: Ints) -> Array:
    """Covariance that a source of unit size causes within each pose, (n, k r, k r), zero for absent rows.

    Args:
        effect: (m, k, q).
        group: Rows with one number share their errors, (m,).
        table: Rows of each pose, (n, r); -1 where a pose has fewer.
    """
    there = table >= 0
    A = np.where(there[..., None, None], effect[table], 0.0)
    same = (group[table][:, :, None] == group[table][:, None, :]) & there[:, :, None] & there[:, None, :]
    n, r, k, q = A.shape
    A = A.reshape(n, k * r, q)
    return np.asarray(A @ np.swapaxes(A, -1, -2) * same.repeat(k, axis=1).repeat(k, axis=2))


def restricted(
    log_sigma: Array, known: Array, unit: Sequence[Array], e: Array, Q: Array, times: Array | float = 1.0
) -> tuple[float, Array, Array, Array]:
    """Negative log of the restricted likelihood, up to a constant, the two halves of its gradient, and its curvature.

    Args:
        log_sigma: Logarithms of the open standard deviations, (k,).
        known: Covariance of each pose from known sources, (n, s, s) [m²].
        unit: Covariance of each pose from a unit of each open source, k of (n, s, s).
        e: Residuals, (n, s) [m].
        Q: A basis of the residuals' changes by the fitted numbers, (n, s, d).
        times: Multiplicity of each pose, (n,): more than one only where e and Q are zero.

    Returns:
        The value; then the expected (k,) and the observed squares of each open source (k,): the gradient is their
        difference, zero at the optimum. The average of observed and expected information, (k, k), is the curvature
        (Gilmour, Thompson, Cullis 1995, Biometrics 51).
    """
    variance = np.exp(2.0 * log_sigma)
    S_inv = np.linalg.inv(S := known + sum(v * C for v, C in zip(variance, unit, strict=True)))
    B = S_inv @ Q
    columns, d = Q.reshape(e.size, -1), Q.shape[-1]
    H = columns.T @ B.reshape(e.size, d)
    H += np.finfo(float).eps * np.diag(np.diag(H))  # rounding: the error of one pose may be 1e20, of all others zero
    z = np.einsum("nij,nj->ni", S_inv, e)
    z = z - B @ np.linalg.solve(H, columns.T @ z.reshape(-1))
    value = 0.5 * ((times * np.linalg.slogdet(S)[1]).sum() + np.linalg.slogdet(H)[1] + (z * e).sum())
    P = S_inv - (B.reshape(e.size, d) @ np.linalg.inv(H)).reshape(B.shape) @ np.swapaxes(B, -1, -2)
    expected = [v * (times * (C * P).sum(axis=(1, 2))).sum() for v, C in zip(variance, unit, strict=True)]
    moved = np.stack([v * (C @ z[..., None])[..., 0] for v, C in zip(variance, unit, strict=True)], axis=-1)
    there = np.einsum("ni,nik->k", z, moved)
    flat, weighed = moved.reshape(e.size, -1), (S_inv @ moved).reshape(e.size, -1)
    seen = columns.T @ weighed
    information = 2.0 * (flat.T @ weighed - seen.T @ np.linalg.solve(H, seen))
    return float(value), np.array(expected), there, information


def basis(J: Array) -> Array:
    """A basis of the residuals' changes by the fitted numbers, from derivatives (n, s, d); may have null directions."""
    n, s, d = J.shape
    flat = J.reshape(n * s, d)
    flat = flat[:, flat.any(axis=0)]
    length = np.linalg.norm(flat, axis=0)
    U, sv, _ = np.linalg.svd(flat / np.where(length > 0, length, 1.0), full_matrices=False)
    return np.asarray(U[:, sv > RANK * sv.max(initial=0.0)].reshape(n, s, -1))


def estimate(
    known: Array,
    unit: Sequence[Array],
    e: Array,
    Q: Array,
    least: Array,
    most: Array | float = np.inf,
    times: Array | float = 1.0,
) -> tuple[Array, float]:
    """The standard deviations of greatest likelihood, each within its limits, (k,).

    The others are the arguments of `restricted`; the known covariance is regular.

    Returns:
        (k,), each in the unit of its source, its lower limit or nearly zero where the residuals need none; and the
        negative log of the restricted likelihood, up to a constant.
    """
    total = float((e**2).sum())
    alone = np.array([np.sqrt(total / max((times * np.einsum("nii->n", C)).sum(), TINY)) for C in unit])
    count = float((times * np.full(len(e), e.shape[1])).sum())
    if total == 0.0:
        return least, 0.0

    def objective(log_sigma: Array) -> tuple[float, Array, Array]:
        value, expected, there, information = restricted(log_sigma, known, unit, e, Q, times)
        return value / count, (expected - there) / count, information / count

    lowest = np.log(np.minimum(np.maximum(SPAN[0] * alone, least), most))
    highest = np.maximum(np.log(np.minimum(SPAN[1] * alone, most)), lowest)
    begun: list[Array] = []
    for share in STARTS:
        log_sigma = np.clip(np.log(share * alone / np.sqrt(len(unit))), lowest, highest)
        for _ in range(CALM_STEPS):
            _, expected, there, _ = restricted(log_sigma, known, unit, e, Q, times)
            log_sigma = log_sigma + 0.25 * (np.log(np.maximum(there, TINY)) - np.log(np.maximum(expected, TINY)))
            log_sigma = np.clip(log_sigma, lowest, highest)
        if not any(np.abs(log_sigma - other).max() < TOGETHER for other in begun):
            begun.append(log_sigma)
    found = [_descended(objective, start, lowest, highest) for start in begun]
    best, value = min(found, key=lambda end: end[1])
    return np.exp(best), value * count


def _descended(
    objective: Callable[[Array], tuple[float, Array, Array]], x: Array, lowest: Array, highest: Array
) -> tuple[Array, float]:
    """The end of Newton's steps within bounds, (k,), and the objective there.

    The curvature is along logarithms of the standard deviations, no less than the slope: it nearly vanishes for a
    source that is far too large or too small.
    """
    value, slope, curvature = objective(x)
    for _ in range(MOST_STEPS):
        free = ~(((x <= lowest) & (slope > 0.0)) | ((x >= highest) & (slope < 0.0)))
        if np.abs(slope[free]).max(initial=0.0) <= ENOUGH:
            break
        bent = np.where(np.outer(free, free), curvature, 0.0) + np.diag(np.where(free, np.abs(slope), 1.0))
        step = np.linalg.solve(bent, np.where(free, -slope, 0.0))
        step *= min(1.0, LONGEST_STEP / float(np.abs(step).max()))
        for length in 0.5 ** np.arange(HALVINGS):
            there = np.clip(x + length * step, lowest, highest)
            lower, turned, other = objective(there)
            if lower <= value + SUFFICIENT * (slope @ (there - x)):
                break
        else:
            break
        gain = value - lower
        x, value, slope, curvature = there, lower, turned, other
        if gain <= ENOUGH * max(abs(value), 1.0) * CONVERGED:
            break
    return x, value
