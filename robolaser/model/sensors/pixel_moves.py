"""How a stripe's residuals move with their pixels."""

from typing import Any

import numpy as np

from robolaser.arrays import Array
from robolaser.duals import Dual, bare
from robolaser.model.sensors.placements import motion
from robolaser.model.sensors.stripe_scanner import StripeScanner
from robolaser.model.stages import Perturbation
from robolaser.parameters import Values


def pixel_moves(sensor: StripeScanner, values: Values, T_base_flange: Array, perturb: Perturbation) -> Array:
    """Move of each residual with its own pixel's u and v, one candidate, (m, 3, 2) [m/px].

    Where points come from images of a board, the known place of a row is its very pixel carried to the board by the
    homography, so it moves with the noise too. For all pixels both stay on one viewing ray o + λ r, the known place
    where the ray meets the board (λ_b), the predicted one where it meets the laser plane (λ_s): the residual is
    (λ_b − λ_s) r, and near the optimum, where λ_b ≈ λ_s, its derivative is r (∂λ_b − ∂λ_s). The board is z = 0 of
    the target's frame where the parameters place it, else the plane through all target points.
    """
    dataset = sensor.dataset
    pixel = dataset.points["pixel"]

    at: Any = Dual(pixel[None], np.broadcast_to(np.eye(2)[:, None, None], (2, 1, *pixel.shape)), (0, 1))
    seen: Any = sensor.in_base(values, T_base_flange, perturb, pixel=at)[0]
    if dataset.board is None:
        return np.asarray(-np.moveaxis(seen.slopes, 0, -1))

    centre = (T_base_flange @ sensor.mount(values, perturb))[0, :, :3, 3]
    centre = np.broadcast_to(centre, (len(dataset.poses), 3))[dataset.points.pose]
    if dataset.placed:
        known = sensor.target(values, perturb)[0]
        origin, normal = known.mean(axis=0), np.linalg.svd(known - known.mean(axis=0), full_matrices=False)[2][2]
    else:
        T_base_target = motion(values, "target")[0]
        origin, normal = T_base_target[:3, 3], T_base_target[:3, 2]

    along = seen - centre
    to_plane = np.linalg.norm(along, axis=-1, keepdims=True)
    ray = along / to_plane
    gap: Any = ((origin - centre) @ normal)[:, None] / (ray @ normal)[:, None] - to_plane
    return np.asarray(bare(ray)[:, :, None] * np.moveaxis(gap.slopes, 0, -1))
