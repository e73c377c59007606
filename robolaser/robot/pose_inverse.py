"""Joint values that bring a flange to given poses, by damped Newton steps from one start or another.

The damping falls with the square of what is missing, so that a pose need not lie in reach, nor a posture be regular.
Sugihara 2011, Solvability-unconcerned inverse kinematics by the Levenberg-Marquardt method, IEEE T-RO 27(5).
"""

from collections.abc import Callable

import numpy as np

from robolaser.arrays import Array, Bools
from robolaser.geometry.rigid_motion import log_so3

STEPS = 60
STRIDE = 0.5  # at most, in a joint [rad or m]
DAMPING = 0.1  # of the squared slopes, times the square of what is missing,
LEAST_DAMPING = 1e-9  # and beyond it
REACHED = 1e-9  # [m, rad]
STARTS = 40  # beside the one that is given: fewer leave out some of what a six-axis arm reaches


def inverse(
    forward: Callable[[Array], Array],
    jacobian: Callable[[Array], Array],
    goal: Array,
    start: Array,
    limits: tuple[Array, Array],
) -> tuple[Array, Bools]:
    """Joint values (n, j), and whether each pose was reached, (n,).

    Args:
        forward: Joint values (n, j) to poses (n, 4, 4).
        jacobian: Joint values (n, j) to velocity and angular velocity of the pose's origin, (n, 6, j).
        goal: Poses, (n, 4, 4).
        start: Where to start, (n, j) [rad or m].
        limits: Least and most that each joint may be, (j,) and (j,) [rad or m].
    """
    rng, lower, upper = np.random.default_rng(0), *limits
    q, reached = _from(forward, jacobian, goal, start, limits)
    for _ in range(STARTS):
        missed = np.flatnonzero(~reached)
        if not len(missed):
            break
        other = rng.uniform(lower, upper, (len(missed), q.shape[1]))
        q[missed], reached[missed] = _from(forward, jacobian, goal[missed], other, limits)
    return q, reached


def _from(
    forward: Callable[[Array], Array],
    jacobian: Callable[[Array], Array],
    goal: Array,
    start: Array,
    limits: tuple[Array, Array],
) -> tuple[Array, Bools]:
    q = np.clip(start, *limits)
    for _ in range(STEPS):
        miss = _miss(goal, forward(q))
        if (np.abs(miss) < REACHED).all():
            break
        J = jacobian(q)
        Jt = np.swapaxes(J, -1, -2)
        damping = LEAST_DAMPING + DAMPING * (miss**2).sum(axis=1)[:, None, None]
        step = (Jt @ np.linalg.solve(J @ Jt + damping * np.eye(6), miss[..., None]))[..., 0]
        step *= np.minimum(1.0, STRIDE / np.maximum(np.abs(step).max(axis=1), 1e-12))[:, None]
        q = np.clip(q + step, *limits)
    return q, np.asarray((np.abs(_miss(goal, forward(q))) < REACHED).all(axis=1))


def _miss(goal: Array, T: Array) -> Array:
    """Shift and turn from poses to others, in the base frame, (n, 6) [m, rad]."""
    turn = log_so3(goal[:, :3, :3] @ np.swapaxes(T[:, :3, :3], -1, -2))
    return np.concatenate([goal[:, :3, 3] - T[:, :3, 3], turn], axis=-1)
