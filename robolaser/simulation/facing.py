"""Configurations in which what an arm carries faces what stands in the cell: a camera and a board, either way round."""

from collections.abc import Callable

import numpy as np

from robolaser.arrays import Array, Bools
from robolaser.errors import RobotError
from robolaser.geometry.rigid_motion import apply
from robolaser.robot.inverse_kinematics import touching
from robolaser.robot.kinematics import Robot
from robolaser.robot.postures import farthest_first, foot_of, most_crowded, random_configurations

DEPTH_M = (0.35, 0.8)  # distances from the camera to the board
TILT = 40 * np.pi / 180  # of the view against the vertical at most: beyond, squares get too narrow
BATCH, BATCHES = 4000, 40
SPARE, MOST_SPARE = 3, 60
CLEAR = 0.3  # of the arm's reach, about the base's axis, in which nothing stands
NEAR_M = 0.2  # from the middle of what stands in the cell to the point that is looked at, along each axis of it


def configurations_facing(
    robot: Robot,
    T_flange_carried: Array,
    sees: Callable[[Array, Array], Bools],
    *,
    wanted: int,
    rng: np.random.Generator,
    place: Array | None = None,
) -> tuple[Array, Array]:
    """Configurations in which what is carried looks down on one place, at many tilts, turns and distances.

    Args:
        robot: Any arm.
        T_flange_carried: Its z axis looks, (4, 4).
        sees: Whether the camera sees the board, for T_base_carried (n, 4, 4) and the place looked at, (3,) [m].
        wanted: How many are needed; spares follow.
        rng: Random numbers.
        place: What is looked at, (3,) [m]; when absent, the place that most configurations look down on.

    Returns:
        Configurations (≥ wanted, j), ones far from each other first, and the place, (3,) [m].

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
    T: Array = robot.forward(q[None])[0] @ T_flange_carried
    return T


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
