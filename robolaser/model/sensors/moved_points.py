"""Points carried by motions, together with how they move: the chain rule for both."""

import numpy as np

from robolaser.arrays import Array, Ints
from robolaser.geometry.rigid_motion import carry, inverse
from robolaser.model.tangents import Tangent, carried


def moved(T: Tangent, of_row: Ints, points: Tangent) -> Tangent:
    """Points carried from frame b to frame a.

    Args:
        T: T_a_b, (c or 1, n, 4, 4).
        of_row: Which of the n is each row's, (m,).
        points: In frame b, (c or 1, m, 3) [m].
    """
    value = carry(T.value, of_row, points.value)
    slopes = _turned(T.value, of_row, points.slopes), carried(T, of_row, points.value)
    return _joined(value, slopes, np.append(points.of, T.of))


def moved_back(T: Tangent, of_row: Ints, points: Tangent) -> Tangent:
    """Points carried from frame a to frame b by T_a_b; arguments as those of `moved`."""
    T_b_a = inverse(T.value)
    value = carry(T_b_a, of_row, points.value)
    slopes = _turned(T_b_a, of_row, points.slopes), -_turned(T_b_a, of_row, carried(T, of_row, value))
    return _joined(value, slopes, np.append(points.of, T.of))


def _turned(T: Array, of_row: Ints, slopes: Array) -> Array:
    """Slopes of points (c or 1, q, m, 3) in the other frame."""
    return (T[:, None, of_row, :3, :3] @ slopes[..., None])[..., 0]


def _joined(value: Array, slopes: tuple[Array, Array], of: Ints) -> Tangent:
    c = max(map(len, slopes))
    return Tangent(value, np.concatenate([np.broadcast_to(part, (c, *part.shape[1:])) for part in slopes], axis=1), of)
