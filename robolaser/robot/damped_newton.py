"""Joint values at which the distance from a goal vanishes, by damped Newton steps within the joints' limits.

The damping falls with the square of the distance, so that a goal need not be in reach, nor a posture be regular.
Sugihara 2011, Solvability-unconcerned inverse kinematics by the Levenberg-Marquardt method, IEEE T-RO 27(5).
"""

from collections.abc import Callable

import numpy as np

from robolaser.arrays import Array, Bools

Missing = Callable[[Array], tuple[Array, Array]]
"""Joint values (n, j) to the goal less what they reach, (n, k), and the derivatives of the latter, (n, k, j)."""

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
    q = np.clip(start, *limits)
    for _ in range(STEPS):
        miss, J = missing(q)
        if (np.abs(miss) < reached).all():
            break
        Jt = np.swapaxes(J, -1, -2)
        damping = LEAST_DAMPING + DAMPING * (miss**2).sum(axis=1)[:, None, None]
        step = (Jt @ np.linalg.solve(J @ Jt + damping * np.eye(J.shape[1]), miss[..., None]))[..., 0]
        step *= np.minimum(1.0, STRIDE / np.maximum(np.abs(step).max(axis=1), 1e-12))[:, None]
        q = np.clip(q + step, *limits)
    return q, np.asarray((np.abs(missing(q)[0]) < reached).all(axis=1))
