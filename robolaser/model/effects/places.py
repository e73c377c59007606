"""The places of a robot at which effects can sit."""

from robolaser.arrays import Array
from robolaser.data.dataset import Dataset
from robolaser.model.effects.scene import Scene


def moving_joints(dataset: Dataset) -> tuple[str, ...]:
    """The joints between base and flange, base first; none where flange poses were measured."""
    robot = dataset.robot
    return () if robot is None else tuple(robot.joints[i] for i in robot.chain)


def turning_joints(dataset: Dataset) -> tuple[str, ...]:
    """Those of them that turn, and do not slide."""
    robot = dataset.robot
    return () if robot is None else tuple(robot.joints[i] for i in robot.chain if not robot.prismatic[i])


def joint_column(scene: Scene, joint: str) -> int:
    """The column of a joint in q."""
    assert scene.robot is not None  # `places` offers joints only where there is a robot
    return scene.robot.joints.index(joint)


def moved(value: Array, scene: Scene, joint: str, by: Array) -> Array:
    """Joint values (c or 1, n, j) with one joint moved by (c, n or 1) [rad or m], (c, n, j)."""
    bent = spread(value, len(by))
    bent[:, :, joint_column(scene, joint)] += by
    return bent


def spread(value: Array, candidates: int) -> Array:
    """A copy of what passes that may be written into, with an entry for each candidate, (c or 1, ...) -> (c, ...)."""
    return value.repeat(candidates, axis=0) if len(value) == 1 else value.copy()
