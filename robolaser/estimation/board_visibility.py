"""Postures from which a camera or a scanner sees its whole board; the arm carries either."""

from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import ClassVar, Self, final

import numpy as np

from robolaser.arrays import Array, Bools
from robolaser.data.board import Board
from robolaser.data.dataset import Dataset, Points
from robolaser.errors import DataError
from robolaser.geometry.rigid_motion import apply, inverse
from robolaser.model.sensors import sensor_class
from robolaser.model.sensors.camera_projection import project
from robolaser.model.sensors.in_cell import is_static
from robolaser.model.sensors.placements import SIX, motion
from robolaser.model.sensors.scanner_geometry import view_of
from robolaser.parameters import Values
from robolaser.robot.inverse_kinematics import touching
from robolaser.robot.kinematics import Robot
from robolaser.robot.postures import random_configurations
from robolaser.robot.visibility import TILT, View

NEAR, FAR = 1.3, 2.5  # distances of the board, in distances at which it would just fill the image
SLANT = 50 * np.pi / 180  # of a board at which a camera still finds it well [rad]
MARGIN = 0.04  # of the image, left free around the board
ASIDE = 0.3  # the stripe crosses the image's middle, or this share of its half beside it
ALONG = 7  # points that represent the stripe


@final
@dataclass(frozen=True)
class CameraBoard:
    """A camera and its board, one of the two on the flange."""

    robot: Robot
    board: Board
    values: Values  # intrinsics, `hand_eye.*` and `target.*`, one candidate
    image_px: tuple[int, int]  # width and height
    rides: bool  # whether the flange carries the camera

    error: ClassVar[float] = 0.2  # usual error of a row [px]

    @property
    def corners(self) -> Array:
        """The board's inner corners in its own frame, (k, 3) [m]."""
        return self.board.corners.reshape(-1, 3)

    def tried(self, count: int, rng: np.random.Generator) -> Array:
        """Postures with the board's middle in front of the camera, (≤ count, j)."""
        size = np.ptp(self.corners, axis=0)[:2].max()
        filling = size * float(self.values["fx"][0]) / min(self.image_px)
        ahead = np.array([0.0, 0.0, filling * rng.uniform(NEAR, FAR)])
        seen, seeing = apply(self._motion("target"), self.corners.mean(axis=0)), apply(self._motion("hand_eye"), ahead)
        carried, goal = (seeing, seen) if self.rides else (seen, seeing)
        start = random_configurations(self.robot, count, rng)
        start = start[-self._board_in_camera(start)[:, 2, 2] < -np.cos(2 * TILT)]
        q, reached = touching(self.robot, carried, goal + rng.uniform(-size / 4, size / 4, (len(start), 3)), start)
        return q[reached]

    def sees(self, q: Array) -> Bools:
        """Whether the whole board is in the image, and not too slanted, (n,)."""
        T = self._board_in_camera(q)
        size = np.array(self.image_px) - 1.0
        with np.errstate(invalid="ignore"):
            inside = np.abs(self._pixels(T) - size / 2.0) <= (0.5 - MARGIN) * size
        return np.asarray((T[:, 2, 2] > np.cos(SLANT)) & inside.all(axis=(1, 2)))

    def points(self, q: Array) -> Points:
        """Every corner, seen from postures (n, j), one after the other."""
        n, k = len(q), len(self.corners)
        names = tuple(map(str, range(k))) * n
        pixel = self._pixels(self._board_in_camera(q)).reshape(-1, 2)
        return Points(np.repeat(np.arange(n), k), names, pixel=pixel, xyz=np.tile(self.corners, (n, 1)))

    def with_board_moved(self, shift: Array) -> Self:
        """The same with the board elsewhere, by (3,) [m], on the flange or in the cell."""
        moved = {f"target.{axis}": self.values[f"target.{axis}"] + by for axis, by in zip("xyz", shift, strict=True)}
        return replace(self, values={**self.values, **moved})

    def too_few(self, wanted: int, tried: int, seeing: int, allowed: int) -> str:
        """A sentence on why too few postures were found: what may be stated wrongly."""
        return (
            f"In {seeing} of {tried} configurations of {self.robot.name} that were tried the camera sees the"
            f" whole board, {allowed} of them are allowed, but {wanted} are wanted. Ask for fewer poses, or correct"
            " hand_eye.x ... and target.x ... in dataset.toml."
        )

    def _motion(self, prefix: str) -> Array:
        return np.asarray(motion(self.values, prefix)[0])

    def _board_in_camera(self, q: Array) -> Array:
        """T_camera_board, (n, 4, 4); z is into the board as the camera sees it."""
        hand_eye, target, flange = self._motion("hand_eye"), self._motion("target"), self.robot.forward(q)
        return inverse(flange @ hand_eye) @ target if self.rides else inverse(hand_eye) @ flange @ target

    def _pixels(self, T_camera_board: Array) -> Array:
        seen = apply(T_camera_board[:, None], self.corners)
        return project(seen.reshape(1, -1, 3), self.values).reshape(*seen.shape[:2], 2)


@final
@dataclass(frozen=True)
class ScannerBoard:
    """A stripe scanner on the flange, and a board in the cell on which the stripe falls."""

    robot: Robot
    board: Board
    view: View
    T_base_target: Array

    error: ClassVar[float] = 1e-4  # usual error of a row [m]

    @property
    def size_m(self) -> Array:
        """From the first inner corner to the last."""
        return self.board.square_m * np.array([self.board.columns - 1, self.board.rows - 1])

    def tried(self, count: int, rng: np.random.Generator) -> Array:
        """Postures with the stripe on the board, (≤ count, j)."""
        start = random_configurations(self.robot, count, rng)
        start = start[np.abs(self._cameras(start)[:, 2, 2]) > np.cos(2 * TILT)]
        inner = rng.uniform(0.1, 0.9, (len(start), 2)) * self.size_m
        goal = apply(self.T_base_target, np.pad(inner, ((0, 0), (0, 1))))
        q, reached = touching(self.robot, self._in_flange(ASIDE * float(rng.choice([-1.0, 0.0, 1.0]))), goal, start)
        return q[reached]

    def sees(self, q: Array) -> Bools:
        """Whether the whole board and the stripe on it are in the image, (n,)."""
        T = self._cameras(q)
        facing = np.sign(T[:, 2, 3])
        good: Bools = -facing * T[:, 2, 2] > np.cos(TILT)
        corners = np.pad(np.array([[0, 0], [0, 1], [1, 0], [1, 1]]) * self.size_m, ((0, 0), (0, 1)))
        good &= self.view.contains(self.view.pixels(apply(inverse(T)[:, None], corners)), MARGIN).all(axis=1)
        frames = self.robot.joint_frames(q)[:, len(self.robot.chain) // 2 :, :3, 3]
        above = apply(inverse(self.T_base_target), frames)[..., 2]
        good &= (facing[:, None] * above > 0).all(axis=1)
        return np.asarray(good & np.isfinite(self._illuminated(T)).all(axis=(1, 2)))

    def points(self, q: Array) -> Points:
        """Some along the stripe, seen from postures (n, j), one after the other."""
        T = self._cameras(q)
        illuminated = self._illuminated(T)
        pixel, xyz = self.view.pixels(illuminated), apply(T[:, None], illuminated)
        names = tuple(map(str, range(ALONG))) * len(q)
        of_pose = np.repeat(np.arange(len(q)), ALONG)
        return Points(of_pose, names, pixel=pixel.reshape(-1, 2), xyz=xyz.reshape(-1, 3))

    def with_board_moved(self, shift: Array) -> Self:
        """The same with the board elsewhere, by (3,) [m]."""
        T = self.T_base_target.copy()
        T[:3, 3] += shift
        return replace(self, T_base_target=T)

    def too_few(self, wanted: int, tried: int, seeing: int, allowed: int) -> str:
        """A sentence on why too few postures were found: possible obstacles."""
        limits = f", and {allowed} of these are allowed" if allowed < seeing else ""
        narrow = "widen [limits] in cell.toml if it may, take a smaller --run-up, " if 2 * allowed < seeing else ""
        return (
            f"{self.robot.name} sees the whole board and the stripe on it from {seeing} of {tried} configurations that"
            f" were tried{limits}, but {wanted} are wanted. Ask for fewer poses, {narrow}move the board nearer to the"
            " middle of the arm's reach, or correct target.x ... in dataset.toml."
        )

    def _in_flange(self, aside: float) -> Array:
        """A point of the laser plane on the flange, in the middle of the stripe or beside it, (3,) [m]."""
        v, across = self.view.values, 1 - self.view.along
        pitch, length = (v["s_u"], v["s_v"])[across], self.view.image_px[across]
        slope = aside * length / 2 * pitch / v["f"]
        depth = v["b"] / (slope + np.tan(v["theta"]))
        return apply(self.view.T_flange_camera, np.array([slope * depth, 0.0, depth]))

    def _cameras(self, q: Array) -> Array:
        """T_target_camera, (n, 4, 4)."""
        return np.asarray(inverse(self.T_base_target) @ self.robot.forward(q) @ self.view.T_flange_camera)

    def _illuminated(self, T_target_camera: Array) -> Array:
        along = np.linspace(*self.view.stripe_range(), ALONG)[None]
        return self.view.illuminated(T_target_camera, 0.0, along)


BoardObserver = CameraBoard | ScannerBoard


def board_observer(description: Dataset) -> BoardObserver:
    """The camera or scanner and the board that a data set states; lens terms that it does not state are zero.

    Raises:
        DataError: It does not state all that is needed.
    """
    scans = sensor_class(description.kind).has_laser_plane()
    robot, board, size = description.robot, description.board, description.image_px
    if robot is None or size is None:
        raise _cannot_plan("the cell has no [robot], or no camera")
    if board is None:
        raise _cannot_plan("dataset.toml has no [board], so there is no target to look at")
    pinhole = () if scans else ("fx", "fy", "cx", "cy", *(f"hand_eye.{part}" for part in SIX))
    _check_stated(description, (*pinhole, *(f"target.{part}" for part in SIX)))
    values = {name: np.array([item.nominal]) for name, item in description.parameters.items()}
    if scans:
        return ScannerBoard(robot, board, view_of(description, values), motion(values, "target")[0])
    lens = {name: np.zeros(1) for name in ("k1", "k2", "p1", "p2", "k3")}
    rides = not is_static(description)
    return CameraBoard(robot, board, lens | values, size, rides)


def _check_stated(description: Dataset, needed: Sequence[str]) -> None:
    missing = [name for name in needed if name not in description.parameters]
    if missing:
        raise DataError(
            f"dataset.toml, [parameters] lacks {', '.join(missing)}: poses that see the target can only be planned"
            " if its position is known to a few centimetres. State it with [target] placed = false, or give your own"
            " poses with --poses.",
            file="dataset.toml",
        )


def _cannot_plan(lacking: str) -> DataError:
    return DataError(f"Poses cannot be planned: {lacking}. Or give your own poses with --poses.", file="dataset.toml")
