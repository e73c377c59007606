"""Three angles of a turn: how it changes with them, and which of the triples for one turn keep to bounds."""

import numpy as np

from robolaser.arrays import Array
from robolaser.geometry.rigid_motion import from_angles, to_angles

TAU = 2 * np.pi


def turn(angles: Array, order: str) -> tuple[Array, Array]:
    """The rotation of three angles and the axes it turns about as each of them grows.

    Args:
        angles: (c, 3) [rad].
        order: As in `from_angles`.

    Returns:
        R (c, 3, 3), and the axes (c, 3, 3), one a row: dR/dangle_k = [a_k]× R, and for k <= l the second derivative
        is [a_k]× [a_l]× R.
    """
    R = from_angles(*np.moveaxis(angles, -1, 0), order=order)
    axes = np.zeros_like(R)
    c, s = np.cos(angles[:, 0]), np.sin(angles[:, 0])
    if order == "xyz":
        axes[:, 0, 0], axes[:, 1, 1], axes[:, 1, 2] = 1.0, c, s
    else:
        axes[:, 0, 2], axes[:, 1, 0], axes[:, 1, 1] = 1.0, -s, c
    axes[:, 2] = R[:, :, 2]
    return R, axes


def along(axes: Array, N: Array) -> tuple[Array, Array]:
    """First and second derivatives by the angles of a function <R, G>, linear in the rotation.

    Args:
        axes: Of `turn`, (c, 3, 3).
        N: G Rᵀ, (c, 3, 3).

    Returns:
        (c, 3) and (c, 3, 3).
    """
    axial = np.stack([N[:, 2, 1] - N[:, 1, 2], N[:, 0, 2] - N[:, 2, 0], N[:, 1, 0] - N[:, 0, 1]], axis=-1)
    first = (axes @ axial[..., None])[..., 0]
    trace = np.einsum("kii->k", N)[:, None, None]
    pairs = axes @ np.swapaxes(N, 1, 2) @ np.swapaxes(axes, 1, 2) - trace * (axes @ np.swapaxes(axes, 1, 2))
    upper = np.triu(pairs)
    return first, upper + np.swapaxes(np.triu(pairs, 1), 1, 2)


def angles_within(R: Array, order: str, lower: Array, upper: Array) -> Array:
    """Angles (c, 3) of rotations (c, 3, 3), of all triples that give the same turn the one nearest to the bounds (3,).

    Where the middle angle leaves only the sum or difference of the others, the first is zero.
    """
    w, phi, psi = first = to_angles(R) if order == "xyz" else _zyz(R)
    second = (w + np.pi, np.pi - phi if order == "xyz" else -phi, psi + np.pi)
    triples = [_wrapped(np.stack(one, axis=-1), lower, upper) for one in (first, second)]
    out = [np.abs(np.clip(one, lower, upper) - one).sum(axis=1) for one in triples]
    return np.where((out[0] <= out[1])[:, None], *triples)


def _zyz(R: Array) -> tuple[Array, Array, Array]:
    sin = np.hypot(R[:, 0, 2], R[:, 1, 2])
    phi = np.arctan2(sin, R[:, 2, 2])
    w = np.where(sin > 0, np.arctan2(R[:, 1, 2], R[:, 0, 2]), 0.0)
    c, s = np.cos(w), np.sin(w)
    psi = np.arctan2(c * R[:, 1, 0] - s * R[:, 0, 0], c * R[:, 1, 1] - s * R[:, 0, 1])
    return w, phi, psi


def _wrapped(angles: Array, lower: Array, upper: Array) -> Array:
    """The same angles, whole turns added so that they are as near as can be to the bounds."""
    middle = (lower + upper) / 2
    return np.asarray(angles - TAU * np.round((angles - middle) / TAU))
