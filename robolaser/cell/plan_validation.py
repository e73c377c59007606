"""Validation of a route before its first motion: limits and collisions, at poses and on the way between."""

from collections.abc import Iterator, Sequence
from typing import Self, final

import numpy as np

from robolaser.arrays import Array, Bools
from robolaser.cell.failures import joint_text
from robolaser.cell.route import Waypoint, way
from robolaser.data.cell_config import Box, Cell, Limits
from robolaser.data.dataset import Dataset
from robolaser.errors import PlanError
from robolaser.geometry.rigid_motion import from_quaternion, pose
from robolaser.robot.collision_bodies import Body, carried_bodies, link_bodies, link_radius
from robolaser.robot.collisions import CollisionModel
from robolaser.robot.kinematics import Robot
from robolaser.robot.postures import foot_of

FINE = 0.02
"""Largest motion of all joints together between two checked configurations: 12 mm at 0.6 m, so that no point is farther
than 6 mm from a checked one [rad or m]."""
SLACK = 0.002  # an arm at a limit may read a little beyond it [rad or m]
SENSOR = "the sensor"
LISTED = 12  # violations that a message lists

Broken = tuple[bool, str]  # a violated limit of a straight way: whether its last posture is within it; description


def collision_model(description: Dataset, limits: Limits, boxes: Sequence[Box] = ()) -> CollisionModel:
    """Links, scanner and boxes of a cell, which has a robot."""
    arm = description.robot
    assert arm is not None  # the caller checked it
    radius = limits.link_radius_m or link_radius(arm)
    carried = carried_bodies(SENSOR, arm, tool_points(description), radius)
    places = [pose(from_quaternion(np.array(box.quat)), np.array(box.centre_m)) for box in boxes]
    stated = [Body(box.name, box.link or arm.base, "box", box.size_m, T) for box, T in zip(boxes, places, strict=True)]
    return CollisionModel(arm, [*link_bodies(arm, radius), *carried, *stated])


def tool_points(description: Dataset) -> Array:
    """Nominal camera and light projector in the flange frame, (2, 3) [m]; none where no value is nominal."""
    drawn = description.parameters
    if not {"t_x", "t_y", "t_z", "b"} <= drawn.keys():
        return np.empty((0, 3))
    camera = np.array([drawn[name].nominal for name in ("t_x", "t_y", "t_z")])
    R = from_quaternion(np.array(description.bracket_quat))
    return np.stack([camera, camera + R @ np.array([drawn["b"].nominal, 0.0, 0.0])])


def lowest(robot: Robot, q: Array, tools: Array) -> Array:
    """Height of the lowest moving part in postures (n, j): joint, flange or tool, (n,) [m].

    Tools are points in the flange frame, (k, 3) [m]. The first joint is on the base and does not move.
    """
    flange = robot.forward(q)
    joints = robot.joint_frames(q)[:, 1:, 2, 3]
    sensor = (tools @ np.swapaxes(flange[:, :3, :3], -1, -2) + flange[:, None, :3, 3])[..., 2]
    return np.asarray(np.concatenate([joints, flange[:, 2, 3:], sensor], axis=1).min(axis=1))


def reach(robot: Robot, q: Array) -> Array:
    """Distance of the flange from the foot of the first joint, (n,) [m]."""
    return np.asarray(np.linalg.norm(robot.forward(q)[:, :3, 3] - foot_of(robot), axis=1))


@final
class RouteCheck:
    """Checks a route against joint limits, floor and reach, and distances between bodies.

    Joint limits are the robot's; tools are points in the flange frame, (k, 3) [m].
    """

    def __init__(self, robot: Robot, limits: Limits, tools: Array, bodies: CollisionModel) -> None:
        self.robot, self.limits, self.tools, self.bodies = robot, limits, tools, bodies

    @classmethod
    def of(cls, cell: Cell) -> Self:
        """The check of a cell's limits."""
        bodies = collision_model(cell.description, cell.limits, cell.boxes)
        return cls(cell.robot, cell.limits, tool_points(cell.description), bodies)

    def violations(self, start: Array | None, names: Sequence[str], q: Array) -> list[str]:
        """All violations of a route, (n, j) in order, pose by pose: where, what, and the worst excess.

        The way to the first pose is not checked where the arm's position, (j,), is not known.
        """
        before = q[0] if start is None else start
        found: list[str] = []
        for name, goal in zip(names, q, strict=True):
            steps = 1 + int(np.ceil(np.abs(goal - before).sum() / FINE))
            line = before + (goal - before) * np.linspace(0.0, 1.0, steps + 1)[1:, None]
            for on_the_way, what in (*self._broken(line), *collisions(self.bodies, self.limits.margin_m, line)):
                found.append(f"{'on the way to ' if on_the_way else ''}{name}: {what}")
            before = goal
        return found

    def check(self, start: Array | None, waypoints: Sequence[Waypoint]) -> None:
        """Raise a PlanError with the violations of a route, if it has any; arguments as for `violations`."""
        broken = self.violations(start, *way(waypoints)) if waypoints else []
        if not broken:
            return
        shown = "".join(f"\n  {violation}" for violation in broken[:LISTED])
        rest = f"\n  ... and {len(broken) - LISTED} more" if len(broken) > LISTED else ""
        run_up = ", or take a smaller --run-up" if any(waypoint.approach for waypoint in waypoints) else ""
        raise PlanError(
            f"Nothing was moved, because the plan violates the cell's limits:{shown}{rest}\n"
            f"Leave these poses out{run_up}; if the limits are wrong, correct [limits] or [[box]] in cell.toml, or the"
            " URDF's."
        )

    def allows(self, q: Array, run_up: float) -> Bools:
        """Whether postures (n, j) are allowed, also with all joints a run-up below and above [rad or m]."""
        good: Bools = np.ones(len(q), dtype=np.bool_)
        places = (q, q - run_up, q + run_up)[: 3 if run_up else 1]
        for excess in (excess for place in places for _, excess, *_ in self._excesses(place)):
            good &= excess <= 0.0
        for place in places:
            good[good] = self.bodies.clear(place[good], self.limits.margin_m)
        return good

    def _excesses(self, q: Array) -> Iterator[tuple[str, Array, str, str]]:
        """Each limited quantity, its excess in postures (n, j), (n,), its worst value, and the limit."""
        robot, floor_m, reach_m = self.robot, self.limits.floor_m, self.limits.reach_m
        for i, joint in enumerate(robot.joints if len(q) else ()):
            for sign, end, worst in ((-1.0, robot.lower[i], q[:, i].min()), (1.0, robot.upper[i], q[:, i].max())):
                yield joint, sign * (q[:, i] - end), joint_text(robot, i, worst), joint_text(robot, i, end)
        if floor_m is not None and len(q):
            height = lowest(robot, q, self.tools)
            yield "the lowest part", floor_m - height, f"{height.min():.3f} m", f"{floor_m:.3f} m (floor_m)"
        if reach_m is not None and len(q):
            far = reach(robot, q)
            yield "the flange", far - reach_m, f"{far.max():.3f} m", f"{reach_m:.3f} m (reach_m)"

    def _broken(self, line: Array) -> list[Broken]:
        """Violations of a straight way whose last posture is the pose itself, (s, j)."""
        found: list[Broken] = []
        for what, excess, value, limit in self._excesses(line):
            slack = SLACK if what in self.robot.joints else 0.0
            if excess.max() > slack:
                found.append((bool(excess[-1] <= slack), f"{what} at {value}, limit {limit}"))
        return found


def collisions(model: CollisionModel, margin_m: float, line: Array) -> list[Broken]:
    """Pairs of bodies nearer than a margin [m] on a straight way whose last posture is the pose itself, (s, j)."""
    gaps = model.gaps(line)
    nearest: dict[str, tuple[float, Broken]] = {}
    for k, pair in enumerate(model.pairs):
        name, gap = model.name(pair), float(gaps[:, k].min())
        if gap >= margin_m or gap >= nearest.get(name, (np.inf,))[0]:  # a link may be several bodies
            continue
        how = f"are {1e3 * gap:.1f} mm apart, limit {1e3 * margin_m:g} mm (margin_m)"
        how = f"overlap by {-1e3 * gap:.1f} mm" if gap < 0 else how
        nearest[name] = gap, (bool(gaps[-1, k] >= margin_m), f"{name} {how}")
    return [broken for _, broken in nearest.values()]
