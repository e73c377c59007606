"""Corners of a board, seen by a simulated stripe scanner's camera beside the stripe."""

from collections.abc import Mapping
from dataclasses import replace

import numpy as np

from robolaser.data.dataset import Dataset, Points
from robolaser.data.several_sensors import scanner_with_corners
from robolaser.data.stated_noise import Noise
from robolaser.errors import EffectError
from robolaser.model.forward_model import Model
from robolaser.model.stages import Stage
from robolaser.parameters import as_batch
from robolaser.simulation.setup import Effects

ALONG = 5  # squares of the board along a stripe that crosses the image
ROUNDS = 40  # of a fixed-point iteration that converges by a factor of ten or more each
SETTLED_PX = 1e-9
MARGIN_PX = 2.0
FEWEST = 6  # corners of a pose that locate the board; a pose with fewer has none


def seen_beside(
    exact: Dataset, truth: Mapping[str, float], effects: Effects, noisy: Dataset, noise: Noise, rng: np.random.Generator
) -> Dataset:
    """A data set of two sensors, `stripe` and `camera`: all that the scanner's images show.

    By the scanner's stripe points, exact and noisy, and all true parameters by name.

    Raises:
        EffectError: There is an effect of the target, which is not implemented for corners.
    """
    for one in effects:
        if one.effect.stage is Stage.TARGET:
            raise EffectError(f"{one.effect.name} cannot be simulated for a stripe and corners together.")
    corners = _seen(exact, truth, effects)
    shaken = corners["pixel"] + (noise.pixel_px or 0.0) * rng.standard_normal((len(corners), 2))
    both = scanner_with_corners(noisy, replace(corners, pixel=shaken))
    members = [replace(one, data=replace(one.data, noise=noisy.noise)) for one in both.members]
    return replace(both, members=tuple(members))


def _seen(exact: Dataset, truth: Mapping[str, float], effects: Effects) -> Points:
    """The corners within each image, as the model with its effects predicts them."""
    assert exact.image_px is not None  # a scanner has it
    size, corners = np.array(exact.image_px), _near(exact)
    pixel = np.tile((size - 1) / 2.0, (len(corners), 1))
    values = as_batch(truth)
    off = np.full_like(pixel, np.inf)
    for _ in range(ROUNDS):
        model = Model(scanner_with_corners(exact, replace(corners, pixel=pixel)), effects)
        off = model.blocks.own_rows(model.residuals_at(values)[0], "camera")
        far = np.abs(off) > size  # not in view
        pixel = np.where(far | ~np.isfinite(off), pixel, pixel - off)
        if not (np.abs(off[np.isfinite(off) & ~far]) > SETTLED_PX).any():
            break
    settled = (np.abs(off) <= 1e3 * SETTLED_PX).all(axis=1)
    inside = ((pixel >= MARGIN_PX) & (pixel <= size - 1 - MARGIN_PX)).all(axis=1) & settled
    enough = np.bincount(corners.pose[inside], minlength=len(exact.poses)) >= FEWEST
    return replace(corners, pixel=pixel).take(np.flatnonzero(inside & enough[corners.pose]))


def _near(exact: Dataset) -> Points:
    """Corners of one large board in the target's plane, those near each pose's stripe."""
    points = exact.points
    flat, level = points["xyz"][:, :2], float(np.median(points["xyz"][:, 2]))
    poses = np.unique(points.pose)
    middles = np.stack([flat[points.pose == pose].mean(axis=0) for pose in poses])
    lengths = [float(np.linalg.norm(np.ptp(flat[points.pose == pose], axis=0))) for pose in poses]
    length = float(np.median(lengths))
    square = length / ALONG
    origin = flat.min(axis=0) - length
    columns, rows = (np.ptp(flat, axis=0) + 2 * length) // square + 1
    i, j = np.meshgrid(np.arange(columns), np.arange(rows))
    grid = origin + square * np.stack([i.ravel(), j.ravel()], axis=-1)
    of_pose, number = np.nonzero(np.linalg.norm(grid[None] - middles[:, None], axis=-1) < length)
    place = grid[number]
    names = tuple(f"{int(i.flat[k])}_{int(j.flat[k])}" for k in number)
    xyz = np.column_stack([place, np.full(len(place), level)])
    return Points(poses[of_pose], names, pixel=np.zeros((len(number), 2)), xyz=xyz)
