"""How a stripe's residuals move with their pixels."""

from collections.abc import Callable

import numpy as np

from robolaser.arrays import Array
from robolaser.finite_differences import central_differences
from robolaser.model.sensors.placements import motion
from robolaser.model.sensors.stripe_scanner import StripeScanner
from robolaser.model.stages import Perturbation
from robolaser.parameters import Values

PIXEL_STEP_PX = 0.25  # far above rounding, far below the lens's curvature


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

    def slopes(of_pixel: Callable[[Array], Array]) -> Array:
        def shifted(shifts: Array) -> Array:
            return np.stack([of_pixel(pixel[None] + shift) for shift in shifts])

        return central_differences(shifted, np.full(2, PIXEL_STEP_PX))

    def predicted(at: Array) -> Array:
        seen: Array = sensor.in_base(values, T_base_flange, perturb, pixel=at)[0]
        return seen

    if dataset.board is None:
        return -slopes(predicted)

    centre = (T_base_flange @ sensor.mount(values, perturb))[0, :, :3, 3]
    centre = np.broadcast_to(centre, (len(dataset.poses), 3))[dataset.points.pose]
    if dataset.placed:
        known = sensor.target(values, perturb)[0]
        origin, normal = known.mean(axis=0), np.linalg.svd(known - known.mean(axis=0), full_matrices=False)[2][2]
    else:
        T_base_target = motion(values, "target")[0]
        origin, normal = T_base_target[:3, 3], T_base_target[:3, 2]

    def ray(at: Array) -> tuple[Array, Array]:
        seen = predicted(at) - centre
        length = np.linalg.norm(seen, axis=-1, keepdims=True)
        return seen / length, length

    def gap(at: Array) -> Array:
        direction, to_plane = ray(at)
        to_board: Array = ((origin - centre) @ normal)[:, None] / (direction @ normal)[:, None]
        return to_board - to_plane

    return ray(pixel[None])[0][:, :, None] * slopes(gap)
