"""One frame on one board through all images, where the squares' colours allow several."""

from collections.abc import Sequence
from typing import Final

import numpy as np

from robolaser.arrays import Array
from robolaser.vision.board import heading
from robolaser.vision.lens import Intrinsics, view_board

ROUNDS: Final = 10  # in which images are laid anew against all others; two or three settle it
LARGEST_MISFIT: Final = np.radians(5.0)
"""By which an image may turn otherwise than the flange, on average: poses by hand are off by less. A judgement."""
LEAST_MARGIN: Final = 2.0
LEAST_TOLD: Final = np.radians(1.0)
"""How many times the misfit of the best way, and how much more, every other way must have. Judgements."""

MOST_BY_SIGHT: Final = 2  # ways to lay the frame, up to which sight or turns of the flange always tell them apart

Orientations = Sequence[Array]  # ways to lay the frame on an image's board: grids, (rows, columns, 2) [px]


def oriented(orientations: Sequence[Orientations], R_base_flange: Array, lens: Intrinsics) -> tuple[list[Array], bool]:
    """Choose for each image the way that lays the same frame on the board as in the others, (rows, columns, 2) [px].

    By the robot's turns where the lens is known, else by sight.

    Args:
        orientations: The ways for each of n images, in the order taken.
        R_base_flange: Turn of the flange in each, (n, 3, 3).
        lens: Of the camera.

    Returns:
        One grid for each image, and whether nothing speaks for another way.
    """
    few = max(map(len, orientations), default=0) <= MOST_BY_SIGHT
    if not lens.known or all(len(ways) == 1 for ways in orientations):
        return orient_by_continuity(orientations), few
    grids, is_certain = orient_by_robot(orientations, R_base_flange, lens)
    return grids, is_certain or few


def orient_by_continuity(orientations: Sequence[Orientations]) -> list[Array]:
    """Let x point as nearly as can be as it did in the image before.

    Right while the camera rolls by less than a quarter turn from one image to the next (an eighth for boards
    that look alike after a quarter turn).

    Args:
        orientations: The ways for each image, in the order taken.

    Returns:
        One grid for each image.
    """
    settled: list[Array] = []
    for ways in orientations:
        before = heading(settled[-1]) if settled else 1.0
        settled.append(min(ways, key=lambda way: abs(np.angle(heading(way) / before))))
    return settled


def orient_by_robot(
    orientations: Sequence[Orientations], R_base_flange: Array, lens: Intrinsics
) -> tuple[list[Array], bool]:
    """Let the board turn before the camera from image to image by as much as the flange turned.

    The angle of a turn is the same seen from camera and flange, whatever the hand-eye is. Image by image is laid
    against those before, and then each against all others, until none is laid anew.

    Args:
        orientations: The ways for each of n images.
        R_base_flange: Turn of the flange in each, (n, 3, 3).
        lens: A known lens; the side of a square does not matter here.

    Returns:
        One grid for each image, and whether the flange's turns leave no other way for any of them.
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
        is_certain &= bool(own <= LARGEST_MISFIT and min(more, default=np.inf) >= LEAST_MARGIN * own + LEAST_TOLD)
    return [ways[best] for ways, best in zip(orientations, chosen, strict=True)], is_certain


def _angle(R: Array) -> float:
    return float(np.arccos(np.clip((np.trace(R) - 1) / 2, -1.0, 1.0)))
