"""The places of a robot at which effects can sit."""

from robolaser.dataset import Dataset
from robolaser.effects.effect import Scene


def moving_joints(dataset: Dataset) -> tuple[str, ...]:
    """The joints between base and flange, base first; none where flange poses were measured."""
    robot = dataset.robot
    return () if robot is None else tuple(robot.joints[i] for i in robot.chain)


def joint_column(scene: Scene, joint: str) -> int:
    """The column of a joint in q."""
    assert scene.robot is not None  # `places` offers joints only where there is a robot
    return scene.robot.joints.index(joint)
