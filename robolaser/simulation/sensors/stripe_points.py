"""Where a stripe scanner without noise sees a flat target, with any effects."""

from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from robolaser.arrays import Array, Bools
from robolaser.data.dataset import Dataset, Points
from robolaser.geometry.rigid_motion import apply, inverse
from robolaser.model.effects.effect import CandidateEffect
from robolaser.model.forward_model import Model
from robolaser.model.sensors import scanner_geometry
from robolaser.model.sensors.placements import motion
from robolaser.model.stages import Perturbation
from robolaser.parameters import Values
from robolaser.robot.visibility import View
from robolaser.simulation.sensors.target_inversion import EXACT_M, ROUNDS, nominal_points

SECANT_STEPS = 40
FIRST_STRIDE_PX = 0.5
IMAGE_MARGIN = 0.02  # of the image, so that noise does not carry a pixel out of it


def stripe_points(
    dataset: Dataset,
    candidate_effects: Sequence[CandidateEffect],
    values: Values,
    *,
    view: View,
    at: Array,
    level: float,
) -> tuple[Dataset, Bools]:
    """Follow the stripe along the target: for each place along it, the pixel that shows the target.

    Args:
        dataset: Poses, without points.
        candidate_effects: The effects of the cell.
        values: All parameters and the effects' numbers, one candidate.
        view: The scanner.
        at: Pixel coordinates along the stripe, (n, k).
        level: Height of the target in the base frame, or in its own one where it is not placed [m].

    Returns:
        The data set with points, each given as the target's maker would: on a plane. And which poses show all of
        theirs in the image, (n,).
    """
    n, k = at.shape
    along = view.along
    T_base_target = np.eye(4) if dataset.placed else motion(values, "target")[0]
    camera = dataset.flange() @ view.T_flange_camera
    pixel = view.stripe(camera, float(T_base_target[2, 3] + level), at).reshape(-1, 2)
    names = tuple(str(i) for _ in range(n) for i in range(k))
    points = Points(np.repeat(np.arange(n), k), names, pixel=pixel, xyz=np.zeros((n * k, 3)))
    dataset = replace(dataset, points=points)
    plain = Model(dataset)
    shown = scanner_geometry.in_base(dataset, values, plain.flange(values), plain.perturb(values))[0]
    given = apply(inverse(T_base_target), shown)
    for _ in range(ROUNDS):
        dataset = replace(dataset, points=replace(points, pixel=pixel, xyz=given))
        model = Model(dataset, tuple(candidate_effects))
        perturb = model.perturb(values)
        T = model.flange(values, perturb)
        left = np.abs(model.blocks.residuals(values, T, perturb))[0].max(axis=-1)
        left = np.maximum(left, np.abs(given[:, 2] - level))
        if (left < EXACT_M).all():
            break
        pixel, given = _on_target(dataset, values, T, perturb, pixel, 1 - along, T_base_target, level)
    shown = scanner_geometry.in_camera(dataset.points["pixel"][None], values, perturb, dataset.stripe_axis)[0]
    good = (left < EXACT_M) & view.contains(pixel, IMAGE_MARGIN) & (shown[:, 2] > 0)
    return dataset, np.asarray(good.reshape(n, k).all(axis=1))


def _on_target(
    dataset: Dataset,
    values: Values,
    T_base_flange: Array,
    perturb: Perturbation,
    pixel: Array,
    across: int,
    T_base_target: Array,
    level: float,
) -> tuple[Array, Array]:
    """Move each pixel across the stripe, by the secant method, until what it shows lies on the target."""
    T_target_base = inverse(T_base_target)

    def off(moved: Array) -> tuple[Array, Array]:
        there = pixel.copy()
        there[:, across] = moved
        shown = scanner_geometry.in_base(dataset, values, T_base_flange, perturb, pixel=there[None])[0]
        given = nominal_points(apply(T_target_base, shown), perturb)
        return given[:, 2] - level, given

    before = pixel[:, across]
    now = before + FIRST_STRIDE_PX
    off_before, _ = off(before)
    off_now, given = off(now)
    with np.errstate(divide="ignore", invalid="ignore", over="ignore"):
        for _ in range(SECANT_STEPS):
            slope = (off_now - off_before) / (now - before)
            step = np.where(off_now == off_before, 0.0, -off_now / slope)
            before, off_before = now, off_now
            now = now + step
            off_now, given = off(now)
            if (np.abs(off_now) < EXACT_M / 100).all():
                break
    found = pixel.copy()
    found[:, across] = now
    given[:, 2] = level
    return found, given
