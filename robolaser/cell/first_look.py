"""A look at the first images of a planned recording: they cut off a board that does not lie where dataset.toml says."""

from collections.abc import Mapping
from typing import final

import numpy as np

from robolaser.data.board import Board
from robolaser.data.image_list import UNLIT
from robolaser.errors import CameraError
from robolaser.vision.board import Image
from robolaser.vision.target_corners import target_in

LOOKS = 3
"""Images that are looked at."""
MISSES = 2
"""Images without the whole board that end the recording: a reflection may spoil one."""


@final
class BoardCutOff(CameraError):
    """A plan that goes to the wrong places: to go on with it is of no use."""


@final
class FirstLook:
    """Looks for the whole board in the images of the first poses."""

    def __init__(self, board: Board) -> None:
        self._board = board
        self._looked = 0
        self._missed: list[str] = []

    def at(self, pose: str, images: Mapping[str, Image]) -> None:
        """Look at the images of a pose, by column of poses.csv.

        Raises:
            BoardCutOff: Too many of the first poses do not show the whole board.
        """
        if self._looked == LOOKS:
            return
        self._looked += 1
        seen = target_in(images.get(UNLIT, images["image"]), self._board)
        if not any(np.isfinite(grid).all() for grid in seen):
            self._missed.append(pose)
        if len(self._missed) == MISSES:
            raise BoardCutOff(
                f"The whole board is not visible from {' and '.join(self._missed)}, although the plan expects it."
                " Measure its position again (target.x ... in dataset.toml), check light and focus, and record a new"
                " plan with --force."
            )
