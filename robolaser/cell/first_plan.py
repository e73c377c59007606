"""The first plan of a cell: the board's position, and poses and motions that see it, before any measurement.

A ChArUco board names its corners, so that a camera has to see only a part of it: the plan looks at the board's middle
from a camera along the last joint's axis, and is valid for one that is tilted or off the axis.
"""

from collections.abc import Sequence
from dataclasses import dataclass, replace
from functools import partial
from typing import final

import numpy as np

from robolaser.arrays import Array
from robolaser.cell.plan_validation import RouteCheck, reach
from robolaser.cell.route import Waypoint, numbered
from robolaser.data.cell_config import Cell
from robolaser.data.dataset import Dataset
from robolaser.data.sensor_format import sensor_format
from robolaser.errors import PlanError
from robolaser.estimation.optimal_poses import planned
from robolaser.geometry.rigid_motion import from_quaternion
from robolaser.model.sensors.placements import numbers_of_motion
from robolaser.parameters import Parameter
from robolaser.robot.kinematics import Robot
from robolaser.robot.postures import foot_of, random_configurations
from robolaser.simulation.nominal import facing_outward

AHEAD = 0.55  # distance of the board's middle from the base, in the arm's reach
MIDDLE = (5, 4)  # inner corners of the part of the board that every pose shows
ALL_AROUND_RAD = 6.2
FOCAL = 0.94  # focal length over image width: a usual lens of 56°
SPARE = (0, 5, 20)  # poses that may be lost because the way to them is not free
ASIDE_RAD = 0.3  # largest detour of joints between two poses
OFFSETS = ("joint_offset",)  # that the poses shall also show
TURNS = 2  # reversals of joints on the way to a pose
TRIES = 40


@final
@dataclass(frozen=True, eq=False)
class Layout:
    """Approximate positions of camera and board."""

    T_flange_camera: Array  # (4, 4)
    T_base_board: Array  # (4, 4)
    ahead_m: float  # distance of the board's middle from the foot of the first joint
    front: str  # the direction to it, an axis of the base frame: "+x"


def layout(cell: Cell) -> Layout:
    """A camera at the flange that looks along the last joint's axis, and the board on the table before the arm."""
    robot, board = cell.robot, cell.description.board
    assert board is not None  # a new cell has one
    T_camera, T_board = np.eye(4), np.eye(4)
    T_camera[:3, :3] = from_quaternion(np.array(facing_outward(robot)))
    ahead_m = AHEAD * reach_of(robot)
    front = _front(robot)
    name = "xy"[int(np.abs(front).argmax())]
    T_board[:3, :3] = np.stack([np.cross(front, [0, 0, 1]), -front, [0, 0, -1]], axis=1)
    size = board.square_m * np.array([board.columns - 1, board.rows - 1, 0])
    T_board[:3, 3] = foot_of(robot) * [1, 1, 0] + ahead_m * front - T_board[:3, :3] @ size / 2
    return Layout(T_camera, T_board, ahead_m, f"{'+' if front.sum() > 0 else '-'}{name}")


def first_poses(cell: Cell, count: int, seed: int) -> tuple[Waypoint, ...]:
    """Poses that see the board's middle, each with a free way to the next; a PlanError if there are too few."""
    described, may = _assumed(cell), partial(RouteCheck.of(cell).allows, run_up=ASIDE_RAD / 2)
    for spare in SPARE:
        try:
            chosen = planned(described, count=count + spare, effects=OFFSETS, allowed=may, unsure_m=0.0, seed=seed)
        except PlanError:
            break
        kept = _chained(cell, chosen)
        if len(kept) >= count:
            return numbered(kept[:count])
    raise PlanError(
        f"{cell.robot.name} does not see the middle of this board on the table in front of it from {count} poses"
        " with free ways between them. Ask for fewer poses, or for smaller squares."
    )


def _chained(cell: Cell, q: Array) -> Array:
    """Configurations (n, j) ordered so that each is the nearest with a free way; others are dropped."""
    check = RouteCheck.of(cell)
    kept, left = [q[0]], list(q[1:])
    while left:
        left.sort(key=lambda one: float(np.abs(one - kept[-1]).max()))
        ways = (check.violations(kept[-1], ("",), one[None]) for one in left)
        following = next((i for i, broken in enumerate(ways) if not broken), None)
        if following is None:
            break
        kept.append(left.pop(following))
    return np.array(kept)


def with_motions(cell: Cell, waypoints: Sequence[Waypoint], seed: int) -> tuple[Waypoint, ...]:
    """The same poses, each approached with reversals of all joints, as far as the way is free."""
    check, rng = RouteCheck.of(cell), np.random.default_rng(seed)
    start: Array | None = None
    found = []
    for waypoint in waypoints:
        for far in np.linspace(1.0, 0.2, TRIES):
            aside = far * ASIDE_RAD * rng.uniform(0.3, 1.0, (TURNS, len(waypoint.q)))
            signs = rng.choice([-1.0, 1.0], len(waypoint.q)) * (-1.0) ** np.arange(TURNS)[:, None]
            moved = replace(waypoint, approach=tuple(waypoint.q + signs * aside))
            names, q = zip(*moved.places, strict=True)
            if not check.violations(start, names, np.array(q)):
                break
        else:
            moved = waypoint
        found.append(moved)
        start = waypoint.q
    return tuple(found)


def _assumed(cell: Cell) -> Dataset:
    """The cell's description with the assumed camera and board."""
    described, at = cell.description, layout(cell)
    board, size = described.board, described.image_px
    assert board is not None
    assert size is not None
    left_out = np.array([board.columns - MIDDLE[0], board.rows - MIDDLE[1], 0]) // 2
    T_base_middle = at.T_base_board.copy()
    T_base_middle[:3, 3] += at.T_base_board[:3, :3] @ (board.square_m * left_out)
    focal = FOCAL * size[0]
    values = {"fx": focal, "fy": focal, "cx": size[0] / 2, "cy": size[1] / 2}
    values |= dict.fromkeys(("k1", "k2", "p1", "p2", "k3"), 0.0)
    for name, T in (("hand_eye", at.T_flange_camera), ("target", T_base_middle)):
        values |= numbers_of_motion(T, name)
    units = sensor_format("camera")
    return replace(
        described,
        kind="camera",
        board=replace(board, columns=MIDDLE[0], rows=MIDDLE[1]),
        parameters={
            name: Parameter(name, units.unit_of(name), value, value - 0.1 * scale, value + 0.1 * scale)
            for name, value in values.items()
            for scale in [focal if units.unit_of(name) == "px" else 1.0]
        },
    )


def reach_of(robot: Robot) -> float:
    """Approximate reach of an arm [m]."""
    return float(reach(robot, _straight_ahead(robot)).max())


def _straight_ahead(robot: Robot) -> Array:
    """Configurations whose first joint is in the middle of its range, (n, j)."""
    q = random_configurations(robot, 2000, np.random.default_rng(0))
    q[:, robot.chain[0]] = np.mean([end[robot.chain[0]] for end in robot.range])
    return q


def _front(robot: Robot) -> Array:
    """The axis of the base frame, (3,), that an arm with a limited base joint faces; x for others."""
    lower, upper = (end[robot.chain[0]] for end in robot.range)
    if upper - lower > ALL_AROUND_RAD:
        return np.array([1.0, 0.0, 0.0])
    mean = (robot.forward(_straight_ahead(robot)[None])[0, :, :2, 3] - foot_of(robot)[:2]).mean(axis=0)
    axis = int(np.abs(mean).argmax())
    return np.asarray(np.eye(3)[axis] * np.sign(mean[axis]))
