"""The joints of an arm at which effects can sit, and joint values with one joint moved."""

from robolaser.arrays import Array
from robolaser.model.effects.run import Run
from robolaser.robot.kinematics import Robot


def moving_joints(robot: Robot | None) -> tuple[str, ...]:
    """The joints between base and flange, base first; none where flange poses were measured."""
    return () if robot is None else tuple(robot.joints[i] for i in robot.chain)


def turning_joints(robot: Robot | None) -> tuple[str, ...]:
    """Those of them that turn, and do not slide."""
    return () if robot is None else tuple(robot.joints[i] for i in robot.chain if not robot.prismatic[i])


def joint_column(run: Run, joint: str) -> int:
    """The column of a joint in q."""
    return run.robot.joints.index(joint)


def add_to_joint(q: Array, run: Run, joint: str, move: Array) -> Array:
    """Joint values (c or 1, n, j) with one joint moved by (c, n or 1) [rad or m], (c, n, j)."""
    moved = copy_per_candidate(q, len(move))
    moved[:, :, joint_column(run, joint)] += move
    return moved


def copy_per_candidate(value: Array, candidates: int) -> Array:
    """A copy that may be written into, with an entry for each candidate, (c or 1, ...) -> (c, ...)."""
    return value.repeat(candidates, axis=0) if len(value) == 1 else value.copy()
