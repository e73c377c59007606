"""Simple line-centre detectors: each line separately, around its brightest pixel, without selecting a stripe."""

import warnings

import numpy as np
from scipy.optimize import OptimizeWarning, curve_fit

from robolaser.arrays import Array, Image

REACH = 12


def centre_of_mass(image: Image) -> Array:
    """Centre of gravity of each row above half its peak, in NumPy, (height,) [px]."""
    grey = image.astype(np.float64)
    ground = np.median(grey, axis=1, keepdims=True)
    above = np.maximum(grey - ground - 0.5 * (grey.max(axis=1, keepdims=True) - ground), 0.0)
    with np.errstate(divide="ignore", invalid="ignore"):
        return np.asarray((above @ np.arange(image.shape[1])) / above.sum(axis=1))


def curve_fitted(image: Image) -> Array:
    """Gaussian fit of each row around its brightest pixel by SciPy's curve_fit, (height,) [px]."""
    found = np.full(len(image), np.nan)
    for row, grey in enumerate(image.astype(np.float64)):
        seat = int(grey.argmax())
        x = np.arange(max(0, seat - REACH), min(len(grey), seat + REACH + 1))
        start = (grey[seat] - grey[x].min(), float(seat), 2.0, grey[x].min())
        with warnings.catch_warnings():
            warnings.simplefilter("ignore", OptimizeWarning)
            try:
                found[row] = curve_fit(_bell, x, grey[x], start)[0][1]
            except RuntimeError:
                continue
    return found


def _bell(x: Array, height: float, middle: float, breadth: float, ground: float) -> Array:
    return np.asarray(height * np.exp(-0.5 * ((x - middle) / breadth) ** 2) + ground)
