"""A cloud as dots: no more of them than a browser can handle, coloured by height."""

import numpy as np
from numpy.typing import NDArray

from robolaser.arrays import Array
from robolaser.report.viewer.shapes import Shape, dots
from robolaser.scan.ply import Vertices, positions_of

MOST = 1_000_000  # points: a browser still turns them smoothly, and gets them within a second
CLEAR = 1.0, 99.0  # percentiles between which colours are spread: a stray point would take them all
SPACING = 0.6  # size of a dot over the distance to its neighbours: a surface looks closed, its grain still shows
VIRIDIS = (
    (68, 1, 84), (71, 45, 123), (59, 82, 139), (44, 114, 142), (33, 145, 140),
    (40, 174, 128), (94, 201, 98), (173, 220, 48), (253, 231, 37),
)  # fmt: skip
"""Nine colours at equal steps of Matplotlib's map of that name, which charts of clouds have too."""
LEAST_M, MOST_M = 1e-4, 3e-3  # sizes of dots: smaller ones are not seen, larger ones hide edges


def downsampled(vertices: Vertices, most: int = MOST) -> Shape | None:
    """Evenly spaced points of a cloud; None where it has none."""
    every = max(1, -(-len(vertices) // most))
    positions = positions_of(vertices[::every])
    if not len(positions):
        return None
    low, high = np.percentile(positions, CLEAR, axis=0)
    sides = np.sort(high - low)[1:]
    size = SPACING * float(np.sqrt(sides.prod() / len(positions)))
    return dots("cloud", positions, by_height(positions[:, 2], low[2], high[2]), float(np.clip(size, LEAST_M, MOST_M)))


def by_height(z: Array, low: float, high: float) -> NDArray[np.uint8]:
    """Colours from blue over green to yellow, (n,) -> (n, 3)."""
    share = np.clip((z - low) / (high - low if high > low else 1.0), 0.0, 1.0)
    steps = np.linspace(0.0, 1.0, len(VIRIDIS))
    channels = [np.interp(share, steps, channel) for channel in np.transpose(VIRIDIS)]
    return np.stack(channels, axis=-1).round().astype(np.uint8)
