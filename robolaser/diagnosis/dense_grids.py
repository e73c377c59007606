"""Search over dense grids of frequencies of a wave, or moments of a step, by shared sums over poses.

For frequencies these are Fourier sums over a joint's angles, for moments running sums over time.
"""

from functools import cache

import numpy as np
from scipy.sparse import csr_array

from robolaser.arrays import Array
from robolaser.diagnosis.fit import Fit
from robolaser.estimation.nonlinear_parameters import NEGLIGIBLE
from robolaser.model.grouped_rows import GroupedRows

SPREAD = 12  # grid cells on either side over which a term of a Fourier sum is spread, for twelve correct digits


def gains_of_waves(
    normal: tuple[Array, Array, Array], angle: Array, frequencies: Array, harmonics: tuple[int, ...], scales: Array
) -> Array:
    """Chi-squared that waves of a joint's angle explain together in the linear model, for each frequency, (g,).

    Args:
        normal: Normal equations of free motions of the joint at n poses, see `normal_equations`.
        angle: The joint's angle at these poses, (n,).
        frequencies: Evenly spaced, (g,).
        harmonics: Multiples of the frequency that have waves, (h,).
        scales: Scales of the sine and the cosine of each, (2 h,).
    """
    gradient, own, shared = normal
    by_columns = [fourier_sums(h * angle, np.column_stack([gradient, shared]), frequencies) for h in harmonics]
    waves = np.stack([part for sums in by_columns for part in (sums.imag, sums.real)], axis=1) * scales[:, None]
    squares = np.empty((len(frequencies), len(harmonics), 2, len(harmonics), 2))

    @cache
    def own_sums(multiple: int) -> Array:
        if multiple < 0:
            return np.conj(own_sums(-multiple))
        return fourier_sums(multiple * angle, own[:, None], frequencies)[:, 0]

    for i, j in np.ndindex(len(harmonics), len(harmonics)):
        plus, minus = (own_sums(harmonics[i] + sign * harmonics[j]) / 2.0 for sign in (1, -1))
        squares[:, i, :, j, :] = np.stack(
            [(minus - plus).real, (plus + minus).imag, (plus - minus).imag, (minus + plus).real], axis=-1
        ).reshape(-1, 2, 2)
    whole = squares.reshape(len(frequencies), len(scales), len(scales)) * np.outer(scales, scales)
    return _gains(waves[:, :, 0], whole, waves[:, :, 1:])


def gains_of_steps(fit: Fit, white: Array, when: Array, moments: Array) -> Array:
    """Chi-squared that an effect explains which begins at a moment, for each moment, (g,).

    Args:
        fit: The model.
        white: Derivatives of its whitened residuals by the parameters of the effect acting from the start, (K, a).
        when: Time of each pose, (n,).
        moments: Possible beginnings of the effect, (g,).
    """
    seen, of_number = np.unique(fit.pose_of_number, return_inverse=True)
    basis = np.hstack([fit.at.Q, np.linalg.qr(fit.release)[0]])
    right = np.column_stack([white, fit.at.white, basis[: len(white)]])
    rows = GroupedRows(of_number)
    sums = np.swapaxes(rows.apart(white), 1, 2) @ rows.apart(right)
    order = np.argsort(when[seen])
    after = np.concatenate([np.cumsum(sums[order[::-1]], axis=0)[::-1], np.zeros((1, *sums.shape[1:]))])
    after = after[np.searchsorted(when[seen][order], moments, side="right")]
    a = white.shape[1]
    whole, along, shared = after[:, :, :a], after[:, :, a], after[:, :, a + 1 :]
    return _gains(along - shared @ (basis.T @ fit.at.r), whole, shared)


def _gains(along: Array, whole: Array, shared: Array) -> Array:
    """Largest decrease of chi-squared by columns, from their products with the residuals and with each other, (g,).

    Args:
        along: Products with the residuals, the part that the parameters imitate removed, (g, a).
        whole: Products with each other, that part included, (g, a, a).
        shared: Products with an orthonormal basis of the parameters' columns, (g, a, d).
    """
    a = along.shape[1]
    A = whole - shared @ np.swapaxes(shared, 1, 2)
    squares, left = (np.trace(one, axis1=1, axis2=2)[:, None, None] / a for one in (whole, A))
    A = A + (NEGLIGIBLE * (np.maximum(left, 0.0) + squares) + 1e-12) * np.eye(a)
    return np.asarray(np.einsum("ga,ga->g", along, np.linalg.solve(A, along[..., None])[..., 0]))


def fourier_sums(angle: Array, columns: Array, frequencies: Array) -> Array:
    """Σ columns exp(i f angle) over angles (n,) and columns (n, v), for evenly spaced frequencies f (g,), (g, v).

    Each term is spread over a grid by a Gaussian, and the grid transformed (Greengard, Lee 2004, Accelerating the
    nonuniform fast Fourier transform). Fewer frequencies than cells of the spread are summed directly.
    """
    g = len(frequencies)
    if g <= 2 * SPREAD:
        return np.asarray(np.exp(1j * np.outer(frequencies, angle)) @ columns)
    size = 1 << int(2 * g - 1).bit_length()
    cell, position = 2.0 * np.pi / size, (frequencies[1] - frequencies[0]) * angle[:, None]
    near = np.round(position / cell).astype(np.int64) + np.arange(-SPREAD, SPREAD + 1)
    width = np.pi * SPREAD / (size * (size - 0.5 * g))
    bells = np.exp(-np.square(position - cell * near) / (4.0 * width))
    starts = np.arange(len(near) + 1) * near.shape[1]
    spread = csr_array((bells.ravel(), (near % size).ravel(), starts), shape=(len(near), size))
    number = np.arange(g) - g // 2
    sums = np.fft.ifft(spread.T @ (columns * np.exp(1j * frequencies[g // 2] * angle)[:, None]), axis=0)[number]
    return np.asarray(np.sqrt(np.pi / width) * np.exp(width * number**2)[:, None] * sums)
