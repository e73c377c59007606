"""Postures that bring a point on the flange to given positions, in any configuration of the arm."""

import numpy as np

from robolaser.arrays import Array, Bools, Ints
from robolaser.errors import RobotError
from robolaser.geometry.rigid_motion import apply
from robolaser.robot.damped_newton import solve
from robolaser.robot.kinematics import Robot
from robolaser.robot.postures import farthest_first, limits, most_crowded, random_configurations

REACHED_M = 1e-12
ATTEMPTS = 10
SPARE = 4  # candidates for each posture wanted
PATCH = 0.3  # radius of the candidate positions, over the reach


def touching(robot: Robot, tool: Array, goal: Array, q: Array, *, still: Bools | None = None) -> tuple[Array, Bools]:
    """Bring a point on the flange to given positions, the orientation free.

    Args:
        robot: Any arm.
        tool: In the flange frame, (3,) or (n, 3) [m].
        goal: In the base frame, (n, 3) [m].
        q: Where to start, (n, j).
        still: Joints that stay where they start, (j,).

    Returns:
        Joint values (n, j), and whether each is within the limits with the point at its goal, (n,).
    """
    fixed = np.zeros(q.shape[1], dtype=bool) if still is None else still
    tools = np.broadcast_to(tool, goal.shape)

    def missing(values: Array, which: Ints) -> tuple[Array, Array]:
        motion = robot.motion(values[None], by_placements=False)
        point = apply(motion.T_base_flange[0], tools[which])
        return goal[which] - point, np.where(fixed, 0.0, motion.jacobian(point[None])[0, :, :3])

    lower, upper = (np.where(fixed, q, limit) for limit in limits(robot))
    return solve(missing, q, (lower, upper), REACHED_M)


def reaching(robot: Robot, tool: Array, goals: Array, *, wanted: int, rng: np.random.Generator) -> tuple[Array, Ints]:
    """Postures that bring a point on the flange to one of several positions, the wanted ones first.

    Args:
        robot: Any arm.
        tool: In the flange frame, (3,) [m].
        goals: In the base frame, (s, 3) [m].
        wanted: How many are needed, goal after goal; spares follow in the same order.
        rng: Random numbers.

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
        of_goal.append(found[farthest_first(robot.forward(found)[:, :3, :3].reshape(-1, 9))])
    deep = min(len(q) for q in of_goal)
    return np.stack([q[:deep] for q in of_goal], axis=1).reshape(-1, len(robot.joints)), np.tile(
        np.arange(len(goals)), deep
    )


def within_reach(robot: Robot, tool: Array, count: int, rng: np.random.Generator) -> Array:
    """Neighbouring positions that a point on the flange reaches from many sides, (count, 3) [m]."""
    T = robot.forward(random_configurations(robot, 2000 + 50 * count, rng)[None])[0]
    places = apply(T, tool)
    reach = float(np.linalg.norm(places - places.mean(axis=0), axis=-1).max())
    near_most: Array = places[most_crowded(places, PATCH * reach, centres=200)]
    return near_most[farthest_first(near_most)[:count]]
