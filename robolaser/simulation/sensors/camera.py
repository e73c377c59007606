"""A simulated camera: on the flange above a board, or in the cell below a board on the flange."""

from collections.abc import Callable
from dataclasses import dataclass, replace
from typing import ClassVar, Self, final

import numpy as np

from robolaser.arrays import Array, Bools, Ints
from robolaser.data.board import Board
from robolaser.data.dataset import Dataset, Points
from robolaser.data.stated_noise import Noise
from robolaser.errors import RobotError
from robolaser.geometry.rigid_motion import apply, from_angles, from_quaternion, inverse, pose
from robolaser.model.forward_model import Model
from robolaser.model.sensors.camera_projection import project
from robolaser.model.sensors.in_cell import Mounting, is_static
from robolaser.model.sensors.placements import numbers_of_motion
from robolaser.parameters import Parameter, Values, as_batch
from robolaser.robot.inverse_kinematics import touching
from robolaser.robot.kinematics import Robot
from robolaser.robot.postures import farthest_first, foot_of, most_crowded, random_configurations
from robolaser.simulation.nominal import facing_outward
from robolaser.simulation.sensors.simulated_sensor import SimulatedSensor, impossible, moved_within
from robolaser.simulation.setup import Effects, RandomStreams, SensorSetup

IMAGE_PX = (1280, 1024)
INTRINSICS = {  # middle and half range [px, 1]: an industrial camera with a lens of 8 mm
    "fx": (1600.0, 40.0), "fy": (1600.0, 40.0), "cx": (639.5, 15.0), "cy": (511.5, 15.0), "k1": (-0.1, 0.05),
    "k2": (0.1, 0.05), "p1": (0.0, 5e-4), "p2": (0.0, 5e-4), "k3": (0.0, 0.02),
}  # fmt: skip
HIDING = {"radial_distortion": ("k2", "k3"), "tangential_distortion": ("p1", "p2")}
"""Terms of the lens that absorb an effect if they are fitted."""
SQUARE_M = 0.03
ROUNDS, SETTLED_PX = 8, 1e-6  # of effects that depend on the apparent position of the board
FEWEST = 6  # corners that locate a board
SHIFT_M, TURN_RAD = 0.05, 0.3  # distance of a bracket from the flange, and its turn, at most
TILT_RAD = 0.1  # of the part in the cell, at most
MARGIN = 0.02  # of the image, so that noise does not carry a corner out of it
DEPTH_M = (0.35, 0.8)  # distances from the camera to the board
TILT = 40 * np.pi / 180  # of the view against the vertical at most: beyond, squares get too narrow
BATCH, BATCHES = 4000, 40
SPARE, MOST_SPARE = 3, 60
CLEAR = 0.3  # of the arm's reach, about the base's axis, without objects
NEAR_M = 0.2  # from the middle of the part in the cell to the target point of the view, along each axis
GROSS_PX = (5.0, 60.0)  # a corner of another square is mistaken for it


@final
@dataclass(frozen=True)
class SimulatedCamera(SimulatedSensor):
    """A camera that sees every corner of its board in every pose."""

    kind: ClassVar[str] = "camera"
    default_points: ClassVar[int] = 35
    own_noise: ClassVar[tuple[str, str]] = ("pixel", "pixel_px")

    corners: Array  # of the board, (k, 3) [m]

    @classmethod
    def check_counts(cls, *, poses: int, points: int, repeats: int) -> None:
        """A board has some corners."""
        super().check_counts(poses=poses, points=points, repeats=repeats)
        if points < FEWEST:
            raise impossible("number of points", points, f"{FEWEST} or more corners of a board")

    @classmethod
    def describe(cls, dataset: Dataset, setup: SensorSetup) -> Dataset:
        """With its image and board, without parameters of camera, hand-eye and target.

        The terms of the lens that would hide an effect are stated to be zero.
        """
        columns, rows = _board(setup.points)
        return replace(
            dataset,
            placed=setup.options.placed and setup.options.mount == "flange",
            image_px=IMAGE_PX,
            board=Board(columns, rows, SQUARE_M) if min(columns, rows) >= 3 else None,
            options=Mounting(setup.options.mount),
            parameters={
                name: Parameter(name, "", 0.0, 0.0, 0.0)
                for effect, names in HIDING.items()
                for name in names
                if effect in setup.effects
            },
        )

    @classmethod
    def build(cls, dataset: Dataset, setup: SensorSetup, random: RandomStreams) -> Self:
        """A lens within its tolerances, a slightly misaligned bracket, and a board that most poses face."""
        rng, (robot, _) = random.build, dataset.arm
        lens = {name: float(mid + half * rng.uniform(-1.0, 1.0)) for name, (mid, half) in INTRINSICS.items()}
        lens |= {name: item.nominal for name, item in dataset.parameters.items() if name in lens and item.fixed}
        lens |= {name: value for name, value in setup.known.items() if name in lens}
        corners = Board(*_board(setup.points), SQUARE_M).corners.reshape(-1, 3)[: setup.points]
        T_facing_board = pose(np.diag([1.0, -1.0, -1.0]), np.zeros(3)) @ pose(np.eye(3), -corners.mean(axis=0))
        rides = not is_static(dataset)
        outward = from_quaternion(np.array(facing_outward(robot))) @ _turn(rng, np.array([TURN_RAD, TURN_RAD, np.pi]))
        T_flange_bracket = pose(outward, rng.uniform(-SHIFT_M, SHIFT_M, 3))
        upright, place = _turn(rng, np.array([TILT_RAD, TILT_RAD, np.pi])), None
        if setup.hand_eye is not None and rides:
            T_flange_bracket = setup.hand_eye
        elif setup.hand_eye is not None:
            upright, place = setup.hand_eye[:3, :3], setup.hand_eye[:3, 3]

        def seen(T_base_carried: Array, place: Array) -> Bools:
            standing = pose(upright, place)
            camera, board = (T_base_carried, standing) if rides else (standing[None], T_base_carried)
            T_camera_board = inverse(camera) @ board @ T_facing_board
            shown = apply(np.broadcast_to(T_camera_board, (len(T_base_carried), 4, 4))[:, None], corners)
            pixel = project(shown.reshape(1, -1, 3), as_batch(lens)).reshape(*shown.shape[:2], 2)
            return np.asarray(_inside(pixel).all(axis=1))

        candidates, place = configurations_facing(
            robot, T_flange_bracket, seen, wanted=len(dataset.poses), rng=random.place, place=place
        )
        standing = pose(upright, place)
        hand_eye, target = (
            (T_flange_bracket, standing @ T_facing_board) if rides else (standing, T_flange_bracket @ T_facing_board)
        )
        truth = lens | numbers_of_motion(hand_eye, "hand_eye")
        if dataset.placed:
            corners = apply(target, corners)
        else:
            truth |= numbers_of_motion(target, "target")
        return cls(truth, candidates, corners)

    def measure(self, dataset: Dataset, chosen: Ints, values: Values, effects: Effects) -> tuple[Dataset, Bools]:
        """Every corner in the image."""
        n, k = len(dataset.poses), len(self.corners)
        names = tuple(map(str, range(k))) * n
        points = Points(
            np.repeat(np.arange(n), k), names, pixel=np.zeros((n * k, 2)), xyz=np.tile(self.corners, (n, 1))
        )
        pixel = -Model(replace(dataset, points=points)).residuals_at(values)[0]
        for _ in range(ROUNDS if effects else 0):
            there = replace(dataset, points=replace(points, pixel=pixel))
            off = Model(there, effects).residuals_at(values)[0]
            pixel = pixel - off
            if not np.abs(off).max(initial=0.0) > SETTLED_PX:
                break
        good = np.asarray(_inside(pixel).reshape(n, k).all(axis=1))
        return replace(dataset, points=replace(points, pixel=pixel)), good

    @classmethod
    def add_shared_noise(cls, points: Points, noise: Noise, rng: np.random.Generator) -> Points:
        """Errors of the corners on the board, the same in all poses."""
        if noise.target_m is None:
            return points
        off = noise.target_m * rng.normal(size=(int(points.number.max()) + 1, 3))
        return replace(points, xyz=points["xyz"] + off[points.number])

    @classmethod
    def add_gross_errors(cls, dataset: Dataset, rows: Ints, sign: Array, rng: np.random.Generator) -> Dataset:
        """Corners in any direction."""
        way = rng.uniform(-np.pi, np.pi, len(rows))
        far = sign * rng.uniform(*GROSS_PX, len(rows))
        pixel = dataset.points["pixel"].copy()
        by = far[:, None] * np.stack([np.cos(way), np.sin(way)], axis=-1)
        pixel[rows] = moved_within(pixel[rows], by, 0.0, np.array(IMAGE_PX) - 1.0)
        return replace(dataset, points=replace(dataset.points, pixel=pixel))


def _turn(rng: np.random.Generator, most: Array) -> Array:
    w, phi, psi = rng.uniform(-1.0, 1.0, 3) * most
    return from_angles(np.asarray(w), np.asarray(phi), np.asarray(psi))


def _board(points: int) -> tuple[int, int]:
    """Columns and rows of the smallest board, slightly wider than high."""
    rows = max(2, int(np.sqrt(points / 1.4)))
    return -(-points // rows), rows


def _inside(pixel: Array) -> Bools:
    """Whether pixels (..., 2) are well inside the image; those behind the camera are not."""
    size = np.array(IMAGE_PX) - 1.0
    with np.errstate(invalid="ignore"):
        return np.asarray((np.abs(pixel - size / 2.0) <= (0.5 - MARGIN) * size).all(axis=-1))


def configurations_facing(
    robot: Robot,
    T_flange_carried: Array,
    sees: Callable[[Array, Array], Bools],
    *,
    wanted: int,
    rng: np.random.Generator,
    place: Array | None = None,
) -> tuple[Array, Array]:
    """Configurations in which the carried part looks down on one point, at many tilts, turns and distances.

    The z axis of the carried part is the view. `sees` tells whether the camera sees the board, for T_base_carried,
    (n, 4, 4), and the target point, (3,) [m].

    Returns:
        Configurations (≥ wanted, j), ones far from each other first, and the target point, (3,) [m]: by default the one
        that most configurations look down on.

    Raises:
        RobotError: There are too few.
    """
    place = _place(robot, T_flange_carried, rng) if place is None else place
    enough, found, tried = min(SPARE * wanted, wanted + MOST_SPARE), np.empty((0, len(robot.joints))), 0
    for _ in range(BATCHES):
        start = random_configurations(robot, BATCH, rng)
        start = start[_looking_down(_carried(robot, start, T_flange_carried), 2 * TILT)]
        goal = place + rng.uniform(-NEAR_M / 2, NEAR_M / 2, (len(start), 3)) * (1.0, 1.0, 0.0)
        looked_at = apply(T_flange_carried, np.array([0.0, 0.0, rng.uniform(*DEPTH_M)]))
        q, reached = touching(robot, looked_at, goal, start)
        q, tried = q[reached], tried + BATCH
        T = _carried(robot, q, T_flange_carried)
        found = np.concatenate([found, q[_looking_down(T, TILT) & sees(T, place)]])
        if len(found) >= enough:
            break
    if len(found) < wanted:
        raise RobotError(
            f"{robot.name}: {wanted} poses in which the camera sees the board are needed, {len(found)} found in {tried}"
            " random configurations within the joint limits. Ask for fewer poses."
        )
    found = found[:enough]
    T = _carried(robot, found, T_flange_carried)
    features = np.concatenate([T[:, :2, 2] / np.sin(TILT), T[:, :2, 0], T[:, :3, 3] / DEPTH_M[1]], axis=1)
    return found[farthest_first(features)], place


def _carried(robot: Robot, q: Array, T_flange_carried: Array) -> Array:
    return robot.forward(q) @ T_flange_carried


def _looking_down(T: Array, within: float) -> Bools:
    return np.asarray(-T[:, 2, 2] > np.cos(within))


def _place(robot: Robot, T_flange_carried: Array, rng: np.random.Generator) -> Array:
    """The point that most configurations look down on, clear of the base, (3,) [m]."""
    T = _carried(robot, random_configurations(robot, 5 * BATCH, rng), T_flange_carried)
    foot = foot_of(robot)
    reach = float(np.linalg.norm(T[:, :3, 3] - foot, axis=-1).max())
    T = T[_looking_down(T, TILT)]
    seen = apply(T, np.array([0.0, 0.0, sum(DEPTH_M) / 2]))
    seen = seen[np.linalg.norm((seen - foot)[:, :2], axis=-1) > CLEAR * reach]
    if not len(seen):
        raise RobotError(f"{robot.name}: in no configuration within the joint limits does the flange look down.")
    return np.asarray(seen[most_crowded(seen, CLEAR * reach)].mean(axis=0))
