"""The cloud in space, coloured by height."""

import numpy as np

from robolaser.report.scene import Scene, dots
from robolaser.report.viewer.downsampling import CLEAR, by_height
from robolaser.scan.quality import Quality

MOST = 15_000  # points: a page of half a megabyte, and a canvas that follows the hand
FEWEST = 10


def cloud_scene(quality: Quality) -> Scene | None:
    """Points of the cloud, evenly taken; None where there are too few to see a shape."""
    positions = quality.positions[:: max(1, -(-len(quality.positions) // MOST))]
    if len(positions) < FEWEST:
        return None
    low, high = np.percentile(positions, CLEAR, axis=0)
    thin = int(np.argmin(high - low))
    rgb = by_height(positions[:, thin], low[thin], high[thin])
    colours = [f"#{r:02x}{g:02x}{b:02x}" for r, g, b in rgb.tolist()]
    size = 1e3 * (high - low)
    return Scene(
        "The cloud in space",
        f"Coloured along {'xyz'[thin]}, from {1e3 * low[thin]:.4g} to {1e3 * high[thin]:.4g} mm.",
        f"A cloud of {len(positions)} points, {size[0]:.3g} by {size[1]:.3g} by {size[2]:.3g} mm.",
        [dots(positions, colours, size=2.0)],
    )
