"""Directions in which parameters move no residual, told with as few parameters as can be."""

from itertools import combinations

import numpy as np

from robolaser.arrays import Array

NULL = 1e-7
"""Singular values of the Jacobian, its columns of unit length, below this share of the largest are zero.

Its numerical derivatives are exact to about 1e-10; the weakest real direction seen on 25 points is at 1e-5.
"""
LOADING = 1e-4
"""Share of the largest move of a residual from which on a parameter takes part in a null direction: ten times above
what the numerical error of the direction can be."""
FEW = 3  # null directions, up to which all ways to lead them are tried
STEADY = 1e-3  # smallest singular value of the leading block, so that leading by it magnifies no numerical error


def null_directions(J: Array) -> Array:
    """Directions of the parameters that move no residual, with as few parameters each as can be.

    A basis of the null space is brought to reduced echelon form: of the parameters that one direction leads with, the
    others have none. Directions that share no parameter come out apart whatever leads; where they overlap, that form
    is taken which names the fewest.

    Args:
        J: Residuals by parameters, (k, d).

    Returns:
        (n, d), exactly zero for parameters that do not take part, in units of the parameters.
    """
    scale = column_lengths(J)
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


def column_lengths(J: Array) -> Array:
    """Length of each column, (d,); 1 for a column of zeros."""
    lengths = np.linalg.norm(J, axis=0)
    return np.where(lengths > 0.0, lengths, 1.0)


def _echelon(basis: Array) -> Array:
    """Gauss-Jordan elimination, led by the largest entries."""
    basis = basis.copy()
    for lead in range(len(basis)):
        row, column = divmod(int(np.argmax(np.abs(basis[lead:]))), basis.shape[1])
        basis[[lead, lead + row]] = basis[[lead + row, lead]]
        basis[lead] /= basis[lead, column]
        others = np.arange(len(basis)) != lead
        basis[others] -= basis[others, column : column + 1] * basis[lead]
    return basis


def _thin(basis: Array) -> Array:
    """Without the parameters that take no part, (..., n, d)."""
    largest = np.abs(basis).max(axis=-1, keepdims=True, initial=np.finfo(float).tiny)
    return np.where(np.abs(basis) > LOADING * largest, basis, 0.0)
