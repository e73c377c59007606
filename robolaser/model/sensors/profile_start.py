"""Where a profile sensor and its balls are, from profiles and flange poses alone: start values for a fit."""

import numpy as np

from robolaser.arrays import Array, Bools, Ints
from robolaser.model.sensors.tracker_fit import base_and_tools

ROUNDS = 20  # of sides and places in turns
GUESSES = 4  # of the sides, by chance, beside that of balls cut through their middle
LEAST_ROWS = 3  # of a profile on a ball: a circle has three numbers


def circles(points: Array, group: Ints) -> tuple[Array, Array, Bools]:
    """Circles through points, by linear least squares (Kåsa 1976).

    Args:
        points: (m, 2) [m].
        group: Of each point, (m,), each from 0 on.

    Returns:
        Centres (g, 2) and radii (g,) [m], and which groups have points enough.
    """
    order = np.argsort(group, kind="stable")
    counts = np.bincount(group)
    starts = np.cumsum(counts) - counts

    def sums(rows: Array) -> Array:
        return np.add.reduceat(rows[order], starts, axis=0)

    mean = sums(points) / counts[:, None]
    local = points - mean[group]
    A = np.column_stack([2.0 * local, np.ones(len(local))])
    normal, right = sums(A[:, :, None] * A[:, None]), sums(A * (local**2).sum(axis=1, keepdims=True))
    solved = (np.linalg.pinv(normal, hermitian=True) @ right[..., None])[..., 0]
    radius = np.sqrt(np.maximum(solved[:, 2] + (solved[:, :2] ** 2).sum(axis=1), 0.0))
    return mean + solved[:, :2], radius, counts >= LEAST_ROWS


def sensor_and_balls(centre: Array, beside: Array, T: Array, ball: Ints, seed: int = 0) -> tuple[Array, Array, Array]:
    """R and s with R (T ball) + s where profiles put the balls, and the balls.

    A profile does not say on which side of its plane the ball's centre lies. Sides and places are found in turns, from
    several guesses of the sides; the one that leaves least is taken.

    Args:
        centre: Of the circle in each profile, along x and z of the sensor, (g, 2) [m].
        beside: Distance of the ball's centre from the profile's plane, (g,) [m].
        T: Motions that bring balls from where they are fixed to the frame that the sensor is fixed in, (c, g, 4, 4).
        ball: Of each profile, (g,).
        seed: Of the guesses.

    Returns:
        R (c, 3, 3), s (c, 3) [m] and the balls where they are fixed, (c, b, 3) [m].
    """
    c, g = len(T), len(beside)
    rng = np.random.default_rng(seed)
    sides = np.concatenate([np.zeros((1, g)), rng.choice([-1.0, 1.0], (GUESSES, g))])
    side = np.tile(sides, (c, 1))
    repeated = np.repeat(T, len(sides), axis=0)
    measured = np.tile(np.insert(centre, 1, 0.0, axis=1), (len(side), 1, 1))
    for _ in range(ROUNDS):
        measured[..., 1] = side * beside
        R, s, balls = base_and_tools(measured, repeated, ball)
        there = (repeated[..., :3, :3] @ balls[:, ball][..., None])[..., 0] + repeated[..., :3, 3]
        predicted = there @ np.swapaxes(R, -1, -2) + s[:, None]
        before, side = side, np.where(predicted[..., 1] < 0.0, -1.0, 1.0)
        if (side == before).all():
            break
    measured[..., 1] = side * beside
    left = np.square(measured - predicted).sum(axis=(1, 2)).reshape(c, -1)
    best = np.arange(c) * len(sides) + np.argmin(left, axis=1)
    return R[best], s[best], balls[best]
