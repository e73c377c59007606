"""Postures that bring a point on the flange to given places, whichever way the arm is folded."""

from collections.abc import Callable

import numpy as np

from robolaser.arrays import Array, Bools, Ints
from robolaser.errors import RobotError
from robolaser.finite_differences import forward_differences
from robolaser.geometry.rigid_motion import apply
from robolaser.robot.kinematics import Robot
from robolaser.robot.postures import farthest_first, limits, most_crowded, random_configurations

Forward = Callable[[Array], Array]  # joint values (n, j) to T_base_flange (n, 4, 4), whatever bends the arm

NEWTON_STEPS = 40
NEWTON_STRIDE = 0.4  # at most, in a joint [rad or m]
REACHED_M = 1e-12
ATTEMPTS = 10
SPARE = 4  # candidates for each posture wanted
PATCH = 0.3  # radius of the places that are chosen among, over the reach
JOINT_STEP = 1e-6  # of the one-sided differences [rad or m]


def touching(
    robot: Robot,
    tool: Array,
    goal: Array,
    q: Array,
    *,
    still: Bools | None = None,
    forward: Forward | None = None,
) -> tuple[Array, Bools]:
    """Bring a point on the flange to given places, the orientation free.

    Newton's method with the nominal arm's slopes: whatever bends the arm is small beside them.

    Args:
        robot: The nominal arm.
        tool: In the flange frame, (3,) or (n, 3) [m].
        goal: In the base frame, (n, 3) [m].
        q: Where to start, (n, j).
        still: Joints that stay where they start, (j,).
        forward: The arm as it is; the nominal one when absent.

    Returns:
        Joint values (n, j), and whether each stands within the limits with the point at its goal, (n,).
    """
    forward = forward or (lambda q: robot.forward(q[None])[0])
    lower, upper = limits(robot)
    free = np.ones(q.shape[1]) if still is None else np.where(still, 0.0, 1.0)
    start = q
    for _ in range(NEWTON_STEPS):
        miss = goal - apply(forward(q), tool)
        if (np.abs(miss) < REACHED_M).all():
            break
        J = _slopes(robot, tool, q) * free
        Jt = np.swapaxes(J, -1, -2)
        step = (Jt @ np.linalg.solve(J @ Jt + 1e-9 * np.eye(3), miss[..., None]))[..., 0]
        step *= np.minimum(1.0, NEWTON_STRIDE / np.maximum(np.abs(step).max(axis=1), 1e-12))[:, None]
        q = np.where(free > 0.0, np.clip(q + step, lower, upper), start)
    miss = goal - apply(forward(q), tool)
    return q, np.asarray((np.abs(miss) < REACHED_M).all(axis=1))


def _slopes(robot: Robot, tool: Array, q: Array) -> Array:
    """Derivatives of a point on the flange by the joint values (n, j), (n, 3, j); one-sided, enough for Newton."""

    def moved(shifts: Array) -> Array:
        return apply(robot.forward(q + shifts[:, None]), tool)

    return forward_differences(moved, np.full(q.shape[1], JOINT_STEP), apply(robot.forward(q[None]), tool)[0])


def reaching(robot: Robot, tool: Array, goals: Array, *, wanted: int, rng: np.random.Generator) -> tuple[Array, Ints]:
    """Postures that bring a point on the flange to one or another of several places, the wanted ones first.

    Args:
        robot: Any arm.
        tool: In the flange frame, (3,) [m].
        goals: In the base frame, (s, 3) [m].
        wanted: How many are needed, goal after goal; spares follow in the same order.
        rng: Where chance comes from.

    Returns:
        Postures (≥ wanted, j), and the goal of each.

    Raises:
        RobotError: A goal is reached too seldom.
    """
    each = -(-wanted // len(goals))
    of_goal = []
    for goal in goals:
        found, tried = np.empty((0, len(robot.joints))), 0
        for _ in range(ATTEMPTS):
            start = random_configurations(robot, 2 * SPARE * each + 20, rng)
            q, good = touching(robot, tool, np.tile(goal, (len(start), 1)), start)
            found, tried = np.concatenate([found, q[good]]), tried + len(start)
            if len(found) >= each or not len(found):
                break
        if len(found) < each:
            at = ", ".join(f"{part:.3f}" for part in goal.tolist())
            raise RobotError(
                f"{robot.name}: from {tried} starts within the joint limits, {len(found)} configurations reach the"
                f" socket at ({at}) m, but {each} are needed. Ask for fewer poses, or take another seed."
            )
        of_goal.append(found[farthest_first(robot.forward(found[None])[0, :, :3, :3].reshape(-1, 9))])
    deep = min(len(q) for q in of_goal)
    return np.stack([q[:deep] for q in of_goal], axis=1).reshape(-1, len(robot.joints)), np.tile(
        np.arange(len(goals)), deep
    )


def within_reach(robot: Robot, tool: Array, count: int, rng: np.random.Generator) -> Array:
    """Places that a point on the flange reaches from many sides, one by the other, (count, 3) [m]."""
    T = robot.forward(random_configurations(robot, 2000 + 50 * count, rng)[None])[0]
    places = apply(T, tool)
    reach = float(np.linalg.norm(places - places.mean(axis=0), axis=-1).max())
    near_most: Array = places[most_crowded(places, PATCH * reach, centres=200)]
    return near_most[farthest_first(near_most)[:count]]
