"""The weight that the joints of an arm bear, its payload's included."""

import numpy as np

from robolaser.arrays import Array
from robolaser.data.dataset import Poses
from robolaser.geometry.kinematics import Robot


def payload(poses: Poses) -> Array:
    """Mass at the flange in each pose, (n,) [kg]; zeros where it was not written down."""
    return np.zeros(len(poses)) if poses.payload_kg is None else poses.payload_kg


def torques(robot: Robot, poses: Poses) -> Array:
    """What each joint must bear to hold the arm still, (n, j) [Nm or N].

    The URDF's masses, and the payload as a point at the flange's origin.
    """
    assert poses.q is not None  # there is a robot, so there are joint angles
    borne = robot.gravity_torques(poses.q)
    mass = payload(poses)
    return borne + mass[:, None] * of_one_kg(robot, poses.q) if mass.any() else borne


def of_one_kg(robot: Robot, q: Array) -> Array:
    """What each joint must bear to hold one kilogram at the flange's origin, (n, j) -> (n, j) [Nm or N]."""
    frames = robot.joint_frames(q[None])[0]
    tip = robot.forward(q[None])[0, :, :3, 3]
    chain = list(robot.chain)
    axes = np.einsum("nkab,kb->nka", frames[..., :3, :3], robot.axes[chain])
    arms = np.cross(axes, tip[:, None] - frames[..., :3, 3])
    lever = np.where(robot.prismatic[chain][:, None], axes, arms)
    borne = np.zeros_like(q)
    borne[:, chain] = -(lever @ np.array(robot.gravity))
    return borne
