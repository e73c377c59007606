"""One frame of a board in all images, where the squares' colours allow several."""

from collections.abc import Sequence
from typing import Final

import numpy as np

from robolaser.arrays import Array
from robolaser.vision.board import heading
from robolaser.vision.lens import Intrinsics, view_board

ROUNDS: Final = 10  # of comparisons of each image with all others; two or three are usually enough
LARGEST_MISFIT: Final = np.radians(5.0)
"""Largest mean difference between rotations of images and flange: manual poses differ by less. A judgement."""
LEAST_MARGIN: Final = 2.0
LEAST_DIFFERENCE: Final = np.radians(1.0)
"""Factor and difference by which all other orientations must misfit more than the best. Judgements."""

MOST_BY_SIGHT: Final = 2  # orientations that the image sequence or the flange's rotations always distinguish

Orientations = Sequence[Array]  # possible frames on an image's board: grids, (rows, columns, 2) [px]


def oriented(orientations: Sequence[Orientations], R_base_flange: Array, lens: Intrinsics) -> tuple[list[Array], bool]:
    """Choose for each image, as taken, the orientation with the same frame as in the others, (rows, columns, 2) [px].

    By the robot's rotations, (n, 3, 3), where the lens is known, else by the image sequence.

    Returns:
        One grid for each image, and whether there is no evidence for another orientation.
    """
    few = max(map(len, orientations), default=0) <= MOST_BY_SIGHT
    if not lens.known or all(len(ways) == 1 for ways in orientations):
        return orient_by_continuity(orientations), few
    grids, is_certain = orient_by_robot(orientations, R_base_flange, lens)
    return grids, is_certain or few


def orient_by_continuity(orientations: Sequence[Orientations]) -> list[Array]:
    """Choose for each image, as taken, the x direction nearest to that in the previous one.

    Correct while the camera rolls by less than a quarter turn between images (an eighth for boards that look the
    same after a quarter turn).
    """
    settled: list[Array] = []
    for ways in orientations:
        before = heading(settled[-1]) if settled else 1.0
        settled.append(min(ways, key=lambda way: abs(np.angle(heading(way) / before))))
    return settled


def orient_by_robot(
    orientations: Sequence[Orientations], R_base_flange: Array, lens: Intrinsics
) -> tuple[list[Array], bool]:
    """Choose orientations so that the board rotates between images by the same angle as the flange, (n, 3, 3).

    The angle of a rotation is the same in camera and flange, whatever the hand-eye transformation. Each image is
    compared with the previous ones, and then with all others, until no orientation changes. The lens is known.

    Returns:
        One grid for each image, and whether the flange's rotations exclude all other orientations.
    """
    seen = [np.stack([view_board(way, 1.0, lens).R_camera_board for way in ways]) for ways in orientations]
    turned = np.array([[_angle(one.T @ other) for other in R_base_flange] for one in R_base_flange])
    chosen: list[int] = []

    def misfit(i: int, others: Sequence[int]) -> Array:  # of each way, on average [rad]
        apart = [[abs(_angle(S @ seen[j][chosen[j]].T) - turned[i, j]) for j in others] for S in seen[i]]
        return np.mean(apart, axis=1) if others else np.zeros(len(seen[i]))

    for i in range(len(seen)):
        chosen.append(int(misfit(i, range(i)).argmin()))
    others = [[j for j in range(len(seen)) if j != i] for i in range(len(seen))]
    for _ in range(ROUNDS):
        before = list(chosen)
        for i in range(len(seen)):
            chosen[i] = int(misfit(i, others[i]).argmin())
        if chosen == before:
            break
    is_certain = True
    for i, best in enumerate(chosen):
        own, *more = np.roll(misfit(i, others[i]), -best)
        is_certain &= bool(own <= LARGEST_MISFIT and min(more, default=np.inf) >= LEAST_MARGIN * own + LEAST_DIFFERENCE)
    return [ways[best] for ways, best in zip(orientations, chosen, strict=True)], is_certain


def _angle(R: Array) -> float:
    return float(np.arccos(np.clip((np.trace(R) - 1) / 2, -1.0, 1.0)))
