"""Joint configurations from which a scanner on an arm sees a flat target below it."""

from collections.abc import Mapping
from dataclasses import dataclass
from typing import final

import numpy as np

from robolaser.arrays import Array, Bools, Ints
from robolaser.errors import RobotError
from robolaser.geometry.camera import laser_plane
from robolaser.geometry.rigid_motion import apply
from robolaser.parameters import as_batch
from robolaser.robot.kinematics import Robot
from robolaser.robot.postures import farthest_first, foot_of, most_crowded, random_configurations

BATCH = 20_000  # configurations at a time: some ten milliseconds
BATCHES = 20  # tried at most; five times as many if a fifth of the wanted ones has been found
TILT = 35 * np.pi / 180  # the camera looks down within this: steeper, a stripe on a matt target gets too dim
MARGIN = 0.08  # of the image, left free on each side
ROUNDING_PX = 1e-6  # the stripe's ends are on the margin itself
PATCH = 0.3  # radius of the target over the arm's reach
CLEAR = 0.3  # the middle of the stripe keeps this far from the base's axis, over the arm's reach
LEVEL_STEP_M = 0.05
NATURAL = 0.3  # the base's own level is taken if it has this share of the best level's configurations
SPARE = 4  # candidates for each configuration wanted,
MOST_SPARE = 80  # but no more than this beyond them


@final
@dataclass(frozen=True)
class View:
    """The view of a stripe scanner on a flange."""

    T_flange_camera: Array  # (4, 4)
    values: Mapping[str, float]  # uses `f`, `s_u`, `s_v`, `u_0`, `v_0`, `b`, `theta`
    stripe_axis: str  # image axis the stripe runs along
    image_px: tuple[int, int]  # width and height [px]

    @property
    def along(self) -> int:
        """Column of the pixel coordinate that the stripe runs along."""
        return 0 if self.stripe_axis == "u" else 1

    def illuminated(self, T_base_camera: Array, level: float, at: Array) -> Array:
        """Intersection of the laser plane with the plane z = level, for an undistorted lens.

        Args:
            T_base_camera: (n, 4, 4).
            level: Of the target, in the base frame [m].
            at: Pixel coordinates along the stripe, (n or 1, k).

        Returns:
            Points in the camera frame, (n, k, 3) [m]; NaN behind the camera.
        """
        plane = laser_plane(as_batch(self.values))[0, 0]
        pitch, centre = (("s_u", "u_0"), ("s_v", "v_0"))[self.along]
        slope = (at - self.values[centre]) * self.values[pitch] / self.values["f"]
        slope = -slope if self.along == 0 else slope
        normal = T_base_camera[:, 2, :3, None]
        distance = level - T_base_camera[:, 2, 3, None]
        facing = normal[:, 1] * slope + normal[:, 2]
        with np.errstate(divide="ignore", invalid="ignore"):
            depth = (plane[0] * distance - plane[3] * normal[:, 0]) / (plane[0] * facing - plane[2] * normal[:, 0])
            x = (plane[3] - plane[2] * depth) / plane[0]
            return np.stack([x, slope * depth, np.where(depth > 0, depth, np.nan)], axis=-1)

    def pixels(self, point: Array) -> Array:
        """Pixels of points of the camera frame through an undistorted lens, (n, k, 3) [m] -> (n, k, 2) [px]."""
        v = self.values
        x, y = (point[..., i] / point[..., 2] * v["f"] for i in (0, 1))
        image = np.stack([-y, x] if self.stripe_axis == "u" else [x, y], axis=-1)
        image = np.where(point[..., 2:] > 0, image, np.nan)
        return np.asarray(image / (v["s_u"], v["s_v"]) + (v["u_0"], v["v_0"]))

    def stripe(self, T_base_camera: Array, level: float, at: Array) -> Array:
        """Pixels of the stripe on the plane z = level, (n, k, 2) [px]; arguments as for `illuminated`."""
        return self.pixels(self.illuminated(T_base_camera, level, at))

    def stripe_range(self, margin: float = MARGIN) -> tuple[float, float]:
        """First and last pixel along the stripe, a margin (a share of the image) left free."""
        length = self.image_px[self.along] - 1
        return margin * length, (1 - margin) * length

    def contains(self, pixel: Array, margin: float = MARGIN) -> Bools:
        """Whether pixels (..., 2) are in the image, a margin (a share of it) left free."""
        size = np.array(self.image_px) - 1.0
        room = np.abs(pixel - size / 2) <= (0.5 - margin) * size + ROUNDING_PX
        return np.asarray(room.all(axis=-1))


def configurations_looking_down(
    robot: Robot, view: View, *, wanted: int, rng: np.random.Generator
) -> tuple[Array, float]:
    """Configurations from which the whole stripe on a flat target is in the image.

    Configurations are drawn within the joint limits until enough look down on one patch of the target, clear of the
    base; of these, ones far from each other (in position, tilt and heading of the camera) come first.

    Args:
        robot: Any arm.
        view: Its scanner.
        wanted: How many are needed; up to three times as many follow as spares.
        rng: Random numbers.

    Returns:
        Configurations (`wanted` and some more, j), and the height of the target in the base frame [m]: the base's own
        level if the arm can see it, else the level that most postures see.

    Raises:
        RobotError: Not enough are found.
    """
    foot = foot_of(robot)
    kept_q, kept_T = np.empty((0, len(robot.joints))), np.empty((0, 4, 4))
    seeing: Ints = np.empty(0, dtype=np.int64)
    enough = min(SPARE * wanted, wanted + MOST_SPARE)
    down, tried, level = 0, 0, None
    while len(seeing) < enough and tried < BATCH * BATCHES * (5 if 5 * len(seeing) >= wanted else 1):
        q = random_configurations(robot, BATCH, rng)
        T = robot.forward(q)
        reach = float(np.linalg.norm(T[:, :3, 3] - foot, axis=-1).max())
        T = T @ view.T_flange_camera
        steep = -T[:, 2, 2] > np.cos(TILT)
        q, T = q[steep], T[steep]
        down, tried = down + len(q), tried + BATCH
        level = _level(T, view) if level is None else level
        good = np.linalg.norm((_focus(T, view) - foot)[:, :2], axis=-1) > CLEAR * reach
        good &= _sees(robot, q, T, view, level)
        kept_q, kept_T = np.concatenate([kept_q, q[good]]), np.concatenate([kept_T, T[good]])
        seeing = np.flatnonzero(most_crowded(_focus(kept_T, view)[:, :2], PATCH * reach))
    if len(seeing) < wanted:
        raise RobotError(
            f"{robot.name}: {wanted} poses that see the target are needed, {len(seeing)} found. Of {tried} random"
            f" configurations within the joint limits, {down} look down; the others of these miss the level"
            f" z = {level or 0.0:.3g} m of the base frame or show the stripe outside the image. Ask for fewer poses, or"
            " for another rotation of the camera on the flange (bracket_quat)."
        )
    seeing = rng.permutation(seeing)[:enough]
    order = farthest_first(_features(kept_T[seeing], view, PATCH * reach))
    return kept_q[seeing[order]], float(level or 0.0)


def _focus(T_base_camera: Array, view: View) -> Array:
    """Intersection of the laser plane with the optical axis, (n, 3) [m]."""
    depth = abs(view.values["b"] / np.tan(view.values["theta"]))
    return apply(T_base_camera, np.array([0.0, 0.0, depth]))


def _level(T_base_camera: Array, view: View) -> float:
    steps = (_focus(T_base_camera, view)[:, 2] / LEVEL_STEP_M).round().astype(int)
    levels, counts = np.unique(np.append(steps, 0), return_counts=True)
    if counts[levels == 0][0] >= NATURAL * counts.max():
        return 0.0
    return float(levels[np.argmax(counts)] * LEVEL_STEP_M)


def _sees(robot: Robot, q: Array, T_base_camera: Array, view: View, level: float) -> Bools:
    """Whether both ends and the middle of the stripe are in the image, and the forearm is above the target."""
    at = np.linspace(*view.stripe_range(), 3)[None]
    seen: Bools = np.asarray(view.contains(view.stripe(T_base_camera, level, at)).all(axis=1))
    rows = np.flatnonzero(seen)
    if len(rows):
        outer = robot.joint_frames(q[rows])[:, len(robot.chain) // 2 :, 2, 3]
        seen[rows] = (outer > level).all(axis=1)
    return seen


def _features(T_base_camera: Array, view: View, patch: float) -> Array:
    """Position, tilt, heading and height of the camera, each scaled to a width of about one, (n, 7)."""
    position = _focus(T_base_camera, view)[:, :2] / patch
    tilt = T_base_camera[:, :2, 2] / np.sin(TILT)
    height = T_base_camera[:, 2, 3:] / abs(view.values["b"])
    return np.concatenate([position, tilt, T_base_camera[:, :2, 0], height], axis=1)
