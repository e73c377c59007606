"""True line centres in an image of the emulated camera."""

from dataclasses import dataclass

import numpy as np

from robolaser.arrays import Array, Ints
from robolaser.emulator.world.scene import RenderedScene

HALVINGS = 30
ON_LIGHT_M = 1e-7  # a ten-thousandth of a pixel


@dataclass(frozen=True)
class TrueStripe:
    """Centres of the direct stripe in each line of pixels (l): rows for stripe axis "v", columns for "u".

    A line has several (k) if steps are side by side; missing values are NaN, and -1 for a solid.

    Attributes:
        at: Pixel coordinate across the stripe, u for "v" and v for "u", ascending, (l, k) [px].
        point: Illuminated points in the base frame, (l, k, 3) [m].
        solid: Numbers of the solids, (l, k).
    """

    at: Array
    point: Array
    solid: Ints


def true_stripe(scene: RenderedScene, T_base_camera: Array) -> TrueStripe:
    """Bisect between neighbouring pixels on both sides of the laser plane."""
    turn, place, light = T_base_camera[:3, :3], T_base_camera[:3, 3], scene.light
    height, width, axis = scene.eye.height_px, scene.eye.width_px, scene.eye.optics.stripe_axis

    def met(ray: Array) -> tuple[Array, Array, Ints]:
        """Distances from the laser plane, points in the base frame, and solids where rays meet the scene."""
        distance, solid = scene.cast(place, ray @ turn.T)
        with np.errstate(invalid="ignore"):
            seen = ray * distance[:, None]
            return light.off(seen), seen @ turn.T + place, solid

    side = met(scene.eye.all_rays)[0].reshape(height, width) > 0
    step = np.array([1.0, 0.0]) if axis == "v" else np.array([0.0, 1.0])
    v, u = np.nonzero(np.diff(side, axis=1 if axis == "v" else 0))
    low = np.stack([u, v], axis=-1).astype(np.float64)
    high, first = low + step, side[v, u]
    for _ in range(HALVINGS):
        middle = (low + high) / 2
        same = ((met(scene.eye.rays(middle))[0] > 0) == first)[:, None]
        low, high = np.where(same, middle, low), np.where(same, high, middle)
    pixel = (low + high) / 2
    off, point, solid = met(scene.eye.rays(pixel))
    rows = np.flatnonzero((np.abs(off) < ON_LIGHT_M) & (solid >= 0))
    normal = np.stack([scene.solids[solid[row]].normal(point[[row]])[0] for row in rows]) if len(rows) else point[:0]
    rows = rows[scene.reaches(point[rows], normal, turn @ light.source + place)]
    across = 0 if axis == "v" else 1
    line, at = pixel[rows, 1 - across].astype(np.int64), pixel[rows, across]
    order = np.lexsort((at, line))
    line, rows, at = line[order], rows[order], at[order]
    k = np.arange(len(line)) - np.searchsorted(line, line)
    shape = (height, width)[across], int(k.max(initial=0)) + 1
    stripe = TrueStripe(np.full(shape, np.nan), np.full((*shape, 3), np.nan), np.full(shape, -1))
    stripe.at[line, k], stripe.point[line, k], stripe.solid[line, k] = at, point[rows], solid[rows]
    return stripe
