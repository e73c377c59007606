"""Bases of smooth random functions of the coordinates that a gap may depend on: one column for each basis function."""

from collections.abc import Callable, Iterable, Iterator
from functools import lru_cache

import numpy as np

from robolaser.arrays import Array
from robolaser.data.subsampling import MAX_POSES
from robolaser.diagnosis.pose_coordinates import Coordinate
from robolaser.diagnosis.thresholds import SEEN, SMALL_SHARE, SMOOTH

MOST = 24  # most basis functions, except of dents in a target


def smooth(coordinate: Array, length: float = SMOOTH, most: int = MOST) -> Array:
    """Independent basis functions of a smooth function of coordinates (n, k), those of largest variance first, (n, p).

    Eigenvectors of a Gaussian process with a squared-exponential kernel of unit variance; a subset represents many
    values (Williams, Seeger 2001), so that the cost grows linearly. Results are cached: each fit of a diagnosis needs
    the same coordinates.
    """
    values = np.asarray(coordinate, dtype=np.float64).tobytes()
    return _remembered(values, coordinate.shape, length, most, _squared_exponential)


def rough(coordinate: Array) -> Array:
    """Basis of a function of one coordinate (n,) that may have corners, (n, p): a Matérn kernel of order 3/2."""
    return _remembered(np.asarray(coordinate, dtype=np.float64).tobytes(), (len(coordinate), 1), SMOOTH, MOST, _matern)


Kernel = Callable[[Array, Array], Array]


@lru_cache
def _remembered(values: bytes, shape: tuple[int, ...], length: float, most: int, kernel: Kernel) -> Array:
    coordinate = np.frombuffer(values).reshape(shape)
    spread = np.ptp(coordinate, axis=0)
    spread = np.maximum(spread, SMALL_SHARE * spread.max(initial=0.0))
    scaled = (coordinate - coordinate.mean(axis=0)) / np.where(spread > 0, spread, 1.0) / length
    if len(scaled) <= MAX_POSES:
        basis = _basis(kernel(scaled, scaled), most)
    else:
        order = np.lexsort(scaled.T[::-1])
        marks = scaled[order[np.linspace(0, len(order) - 1, MAX_POSES).round().astype(int)]]
        basis = _basis(kernel(marks, marks), most)
        basis = kernel(scaled, marks) @ (basis / (basis**2).sum(axis=0))
    basis.setflags(write=False)
    return basis


def _squares(first: Array, second: Array) -> Array:
    differences = first[:, None, :] - second
    return np.asarray(np.einsum("ijk,ijk->ij", differences, differences))


def _squared_exponential(first: Array, second: Array) -> Array:
    return np.exp(-0.5 * _squares(first, second))


def _matern(first: Array, second: Array) -> Array:
    distances = np.sqrt(3.0 * _squares(first, second))
    return (1.0 + distances) * np.exp(-distances)


def _basis(kernel: Array, most: int) -> Array:
    variance, vectors = np.linalg.eigh(kernel)
    kept = np.flatnonzero(variance > SEEN * variance[-1])[::-1][:most]
    return np.asarray(vectors[:, kept] * np.sqrt(variance[kept]))


def smoothed(coordinates: Iterable[Coordinate], length: float = SMOOTH) -> Iterator[tuple[str, Array]]:
    """Coordinates of poses by name, each with the basis (n, p) of a smooth function of it."""
    return ((one.name, smooth(one.values, length)) for one in coordinates)
