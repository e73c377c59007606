"""Standard deviations of several sources of error from the residuals of a fit: restricted maximum likelihood.

The d fitted numbers made the residuals smaller than the errors; the restricted likelihood uses only the combinations
of residuals that no fitted number can change. Patterson, Thompson 1971, Biometrika 58; Harville 1977.
"""

from collections.abc import Callable, Sequence

import numpy as np

from robolaser.arrays import Array, Ints

SPAN = (1e-4, 1e2)  # search range of a standard deviation, in units of the one that would explain the residuals alone
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


def blocks(effect: Array, group: Ints, table: Ints) -> Array:
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
    total, tiny = float((e**2).sum()), np.finfo(float).tiny
    alone = np.array([np.sqrt(total / max((times * np.einsum("nii->n", C)).sum(), tiny)) for C in unit])
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
            log_sigma = log_sigma + 0.25 * (np.log(np.maximum(there, tiny)) - np.log(np.maximum(expected, tiny)))
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
