"""The truth behind a photograph: what each pixel shows, and where the stripe's middle runs."""

from dataclasses import dataclass
from functools import cached_property
from typing import final

import numpy as np

from robolaser.arrays import Array, Ints
from robolaser.emulator.rendering.laser_sheet import LaserSheet
from robolaser.emulator.rendering.scene_view import SceneView

STEPS = 12
ON_SHEET_M = 1e-7  # a ten-thousandth of a pixel


@final
@dataclass(frozen=True)
class StripeTruth:
    """Middles of the direct stripe in each line of pixels (l): rows for stripe axis "v", columns for "u".

    A line has more than one (k) where steps lie side by side; what is missing is NaN, and -1 for a solid.

    Attributes:
        at: Pixel coordinate across the stripe, u for "v" and v for "u", ascending, (l, k) [px].
        point: What it lights, in the base frame, (l, k, 3) [m].
        solid: Numbers of the solids, (l, k).
    """

    at: Array
    point: Array
    solid: Ints


@final
@dataclass(frozen=True, eq=False)
class Truth:
    """What only who drew the picture knows, each worked out when it is asked for.

    Attributes:
        view: The scene before the eye.
        sheet: The light.
        lit: Whether it was on.
        grey: The image without noise, speckle and the sensor's end of range, (height, width).
    """

    view: SceneView
    sheet: LaserSheet
    lit: bool
    grey: Array

    @property
    def distance(self) -> Array:
        """From the camera to what each pixel's middle shows, (height, width) [m]; inf where there is nothing."""
        return self.view.all.distance.reshape(self.grey.shape)

    @property
    def solid(self) -> Ints:
        """Number of the solid that it is, (height, width), or -1."""
        return self.view.all.solid.reshape(self.grey.shape)

    @cached_property
    def point(self) -> Array:
        """The point itself in the base frame, (height, width, 3) [m]; NaN where there is nothing."""
        point = self.view.outside(self.view.all.seen)
        point[self.view.all.solid < 0] = np.nan
        return point.reshape(*self.grey.shape, 3)

    @cached_property
    def stripe(self) -> StripeTruth:
        """Where the middle of the light meets what the camera sees, nothing between it and the projector."""
        pixel, point, solid = self._crossings()
        across = 0 if self.view.eye.stripe_axis == "v" else 1
        line, at = pixel[:, 1 - across].astype(np.int64), pixel[:, across]
        order = np.lexsort((at, line))
        line, at, point, solid = line[order], at[order], point[order], solid[order]
        place = np.arange(len(line)) - np.searchsorted(line, line)
        shape = self.grey.shape[across], int(place.max(initial=0)) + 1
        stripe = StripeTruth(np.full(shape, np.nan), np.full((*shape, 3), np.nan), np.full(shape, -1))
        stripe.at[line, place], stripe.point[line, place], stripe.solid[line, place] = at, point, solid
        return stripe

    def _crossings(self) -> tuple[Array, Array, Ints]:
        """Pixels (n, 2), points (n, 3) and solids (n,) on the sheet's middle, by regula falsi between pixels."""
        if not self.lit:
            return np.empty((0, 2)), np.empty((0, 3)), np.empty(0, dtype=np.int64)
        off = self.sheet.off(self.view.all.seen).reshape(self.grey.shape)
        step = np.array([1.0, 0.0]) if self.view.eye.stripe_axis == "v" else np.array([0.0, 1.0])
        near, far = (off[:, :-1], off[:, 1:]) if step[0] else (off[:-1], off[1:])
        with np.errstate(invalid="ignore"):
            row, column = np.nonzero((near > 0) != (far > 0))
        start = np.stack([column, row], axis=-1).astype(np.float64)
        f_low, f_high = near[row, column], far[row, column]
        low, high = np.zeros(len(row)), np.ones(len(row))
        hits, last = self.view.along(self.view.eye.rays(start)), np.zeros(len(row))
        share = low
        for _ in range(STEPS):
            with np.errstate(divide="ignore", invalid="ignore"):
                share = np.clip(low - f_low * (high - low) / (f_high - f_low), 0.0, 1.0)
            share = np.where(np.isfinite(share), share, 0.5 * (low + high))
            hits = self.view.along(self.view.eye.rays(start + share[:, None] * step))
            f = self.sheet.off(hits.seen)
            left = (f > 0) == (f_low > 0)
            f_high = np.where(left & (last > 0), 0.5 * f_high, np.where(left, f_high, f))
            f_low = np.where(~left & (last < 0), 0.5 * f_low, np.where(left, f, f_low))
            low, high, last = np.where(left, share, low), np.where(left, high, share), np.where(left, 1.0, -1.0)
        with np.errstate(invalid="ignore"):
            true = np.flatnonzero((np.abs(self.sheet.off(hits.seen)) < ON_SHEET_M) & self.view.lit(self.sheet, hits))
        kept = hits.take(true)
        return (start + share[:, None] * step)[true], self.view.outside(kept.seen), kept.solid
