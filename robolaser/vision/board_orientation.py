"""One frame on one board through all images, where the squares' colours allow several."""

from collections.abc import Sequence

import numpy as np

from robolaser.arrays import Array
from robolaser.vision.board import heading
from robolaser.vision.lens import Lens, view_board

Orientations = Sequence[Array]
"""Every way to lay the frame on the board of one image, each a grid of corners (rows, columns, 2) [px]."""


def oriented(orientations: Sequence[Orientations], R_base_flange: Array | None, lens: Lens) -> list[Array]:
    """Choose for each image the way that lays the same frame on the board as in the others, (rows, columns, 2) [px].

    By the robot's turns where lens and turns are known, else by sight.

    Args:
        orientations: The ways for each of n images, in the order taken.
        R_base_flange: Turn of the flange in each, (n, 3, 3); None where it is not known.
        lens: Of the camera.
    """
    if R_base_flange is None or not lens.known or all(len(ways) == 1 for ways in orientations):
        return orient_by_continuity(orientations)
    return orient_by_robot(orientations, R_base_flange, lens)


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


def orient_by_robot(orientations: Sequence[Orientations], R_base_flange: Array, lens: Lens) -> list[Array]:
    """Let the board turn before the camera from image to image by as much as the flange turned.

    The angle of a turn is the same seen from camera and flange, whatever the hand-eye is.

    Args:
        orientations: The ways for each of n images.
        R_base_flange: Turn of the flange in each, (n, 3, 3).
        lens: A known lens; the side of a square does not matter here.

    Returns:
        One grid for each image.
    """
    settled: list[Array] = []
    turns: list[Array] = []
    for ways, R in zip(orientations, R_base_flange, strict=True):
        seen = [view_board(way, 1.0, lens).R_camera_board for way in ways]
        robot = [_angle(R_before.T @ R) for R_before in R_base_flange[: len(turns)]]
        misfit = [sum(abs(_angle(S @ T.T) - turn) for T, turn in zip(turns, robot, strict=True)) for S in seen]
        best = int(np.argmin(misfit)) if turns else 0
        settled.append(ways[best])
        turns.append(seen[best])
    return settled


def _angle(R: Array) -> float:
    return float(np.arccos(np.clip((np.trace(R) - 1) / 2, -1.0, 1.0)))
