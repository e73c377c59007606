"""Configurations of an arm within its limits, and a choice of them."""

import numpy as np

from robolaser.arrays import Array, Bools, Ints
from robolaser.robot.kinematics import Robot

INSIDE = 0.02  # of a joint's range: stay clear of its limits


def limits(robot: Robot) -> tuple[Array, Array]:
    """Joint limits with a small margin, (j,) and (j,); a continuous joint gets ±π."""
    lower, upper = robot.range
    room = INSIDE * (upper - lower)
    return lower + room, upper - room


def random_configurations(robot: Robot, count: int, rng: np.random.Generator) -> Array:
    """Configurations drawn uniformly within the limits, (count, j)."""
    lower, upper = limits(robot)
    return rng.uniform(lower, upper, (count, len(lower)))


def foot_of(robot: Robot) -> Array:
    """Position of the first joint, (3,) [m]."""
    return np.asarray(robot.joint_frames(np.clip(0.0, robot.lower, robot.upper))[0, :3, 3])


def most_crowded(places: Array, radius: float, centres: int = 500) -> Bools:
    """Mark points (n, k) within a radius of the one of the first, so many, with the most neighbours, (n,)."""
    if not len(places):
        return np.zeros(0, dtype=np.bool_)
    from scipy.spatial import KDTree  # noqa: PLC0415 - takes a while to import

    around = KDTree(places).query_ball_point(places[:centres], radius, return_length=True)
    return np.asarray(np.linalg.norm(places - places[np.argmax(around)], axis=-1) < radius)


def farthest_first(features: Array) -> Ints:
    """Farthest-first order: each is as far as possible from all before it, (n, k) -> (n,)."""
    order = [0]
    nearest = np.linalg.norm(features - features[0], axis=1)
    for _ in range(len(features) - 1):
        nearest[order[-1]] = -1.0
        order.append(int(nearest.argmax()))
        nearest = np.minimum(nearest, np.linalg.norm(features - features[order[-1]], axis=1))
    return np.array(order, dtype=np.int64)
