"""Postures from which a camera sees its whole board, on the flange or in the cell, whichever the arm carries."""

from dataclasses import dataclass
from typing import final

import numpy as np

from robolaser.arrays import Array, Bools
from robolaser.data.dataset import Board, Dataset, Points
from robolaser.geometry.inverse_kinematics import touching
from robolaser.geometry.kinematics import Robot
from robolaser.geometry.rigid_motion import apply, inverse
from robolaser.geometry.visibility import TILT, random_configurations
from robolaser.model.sensors.camera_projection import distort, on_plane, to_pixels
from robolaser.model.sensors.placements import motion
from robolaser.parameters import Values

NEAR, FAR = 1.3, 2.5
"""Distances of the board, in distances at which it would just fill the image."""
MARGIN = 0.04  # of the image, left free around the board


@final
@dataclass(frozen=True)
class CameraBoard:
    """A camera and its board, one of them on the flange.

    Attributes:
        robot: The arm.
        board: What the camera sees.
        values: Intrinsics, `hand_eye.*` and `target.*`, one candidate.
        image_px: Width and height.
        rides: Whether the flange carries the camera.
    """

    robot: Robot
    board: Board
    values: Values
    image_px: tuple[int, int]
    rides: bool

    @property
    def corners(self) -> Array:
        """The board's inner corners in its own frame, (k, 3) [m]."""
        grid = np.stack(np.meshgrid(np.arange(self.board.columns), np.arange(self.board.rows)), axis=-1)
        return self.board.square_m * np.pad(grid.reshape(-1, 2).astype(np.float64), ((0, 0), (0, 1)))

    def tried(self, count: int, rng: np.random.Generator) -> Array:
        """Postures that bring the board's middle somewhere before the camera, (≤ count, j)."""
        size = np.ptp(self.corners, axis=0)[:2].max()
        filling = size * float(self.values["fx"][0]) / min(self.image_px)
        ahead = np.array([0.0, 0.0, filling * rng.uniform(NEAR, FAR)])
        hand_eye, target = (motion(self.values, prefix)[0] for prefix in ("hand_eye", "target"))
        middle = self.corners.mean(axis=0)
        carried, goal = (apply(hand_eye, ahead), apply(target, middle)) if self.rides else (
            apply(target, middle), apply(hand_eye, ahead))  # fmt: skip
        start = random_configurations(self.robot, count, rng)
        start = start[-self._board_in_camera(start)[:, 2, 2] < -np.cos(2 * TILT)]
        aside = rng.uniform(-size / 4, size / 4, (len(start), 3))
        q, reached = touching(self.robot, lambda q: self.robot.forward(q[None])[0], carried, goal + aside, start)
        return q[reached]

    def sees(self, q: Array) -> Bools:
        """Whether the whole board is in the image, and not too slanted, (n,)."""
        T = self._board_in_camera(q)
        size = np.array(self.image_px) - 1.0
        with np.errstate(invalid="ignore"):
            inside = np.abs(self._pixels(T) - size / 2.0) <= (0.5 - MARGIN) * size
        return np.asarray((T[:, 2, 2] > np.cos(TILT)) & inside.all(axis=(1, 2)))

    def points(self, q: Array) -> Points:
        """What is seen from postures (n, j), one after the other."""
        n, k = len(q), len(self.corners)
        names = tuple(map(str, range(k))) * n
        pixel = self._pixels(self._board_in_camera(q)).reshape(-1, 2)
        return Points(np.repeat(np.arange(n), k), names, pixel=pixel, xyz=np.tile(self.corners, (n, 1)))

    def _board_in_camera(self, q: Array) -> Array:
        """T_camera_board, (n, 4, 4); z is into the board as the camera sees it."""
        hand_eye, target = (motion(self.values, prefix)[0] for prefix in ("hand_eye", "target"))
        flange = self.robot.forward(q[None])[0]
        T: Array = inverse(flange @ hand_eye) @ target if self.rides else inverse(hand_eye) @ flange @ target
        return T

    def _pixels(self, T_camera_board: Array) -> Array:
        seen = apply(T_camera_board[:, None], self.corners)
        flat = on_plane(seen.reshape(1, -1, 3))
        return to_pixels(distort(flat, self.values), self.values).reshape(*seen.shape[:2], 2)


def camera_board(description: Dataset, robot: Robot, board: Board, image_px: tuple[int, int]) -> CameraBoard:
    """The camera and board of a data set that states where they are; terms of the lens it does not state are zero."""
    stated = {name: np.array([item.nominal]) for name, item in description.parameters.items()}
    lens = {name: np.zeros(1) for name in ("k1", "k2", "p1", "p2", "k3")}
    rides = description.options is None or description.options.mount == "flange"
    return CameraBoard(robot, board, lens | stated, image_px, rides)
