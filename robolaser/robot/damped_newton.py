"""Joint values at which the distance from a goal vanishes, by damped Newton steps within the joints' limits.

The damping falls with the square of the distance, so that a goal need not be in reach, nor a posture be regular.
Sugihara 2011, Solvability-unconcerned inverse kinematics by the Levenberg-Marquardt method, IEEE T-RO 27(5).
"""

from collections.abc import Callable

import numpy as np

from robolaser.arrays import Array, Bools, Ints

Missing = Callable[[Array, Ints], tuple[Array, Array]]
"""Joint values (m, j), and of which goals, (m,), to these less what they reach, (m, k), and derivatives, (m, k, j)."""

STEPS = 60
STRIDE = 0.5  # at most, in a joint [rad or m]
DAMPING = 0.1  # of the squared slopes, times the square of the distance,
LEAST_DAMPING = 1e-9  # and beyond it


def solve(missing: Missing, start: Array, limits: tuple[Array, Array], reached: float) -> tuple[Array, Bools]:
    """Joint values (n, j), and whether each goal was reached, (n,).

    Args:
        missing: [m or rad].
        start: Joint values where the search starts, (n, j) [rad or m].
        limits: Least and largest value of each joint, (j,) or (n, j) each [rad or m].
        reached: Distance from a goal up to which it is reached [m or rad].
    """
    lower, upper = (np.broadcast_to(limit, start.shape) for limit in limits)
    q, sought = np.clip(start, lower, upper), np.arange(len(start))
    for left in reversed(range(STEPS + 1)):
        miss, J = missing(q[sought], sought)
        far = ~(np.abs(miss) < reached).all(axis=1)
        sought, miss, J = sought[far], miss[far], J[far]
        if not left or not len(sought):
            break
        Jt = np.swapaxes(J, -1, -2)
        damping = LEAST_DAMPING + DAMPING * (miss**2).sum(axis=1)[:, None, None]
        step = (Jt @ np.linalg.solve(J @ Jt + damping * np.eye(J.shape[1]), miss[..., None]))[..., 0]
        step *= np.minimum(1.0, STRIDE / np.maximum(np.abs(step).max(axis=1), 1e-12))[:, None]
        q[sought] = np.clip(q[sought] + step, lower[sought], upper[sought])
    return q, ~np.isin(np.arange(len(q)), sought)
