"""Torques that an arm's joints bear under gravity, the payload's weight included."""

import numpy as np

from robolaser.arrays import Array
from robolaser.geometry.kinematics import Robot


def gravity_torques(robot: Robot, q: Array, payload_kg: Array | None) -> Array:
    """What each joint must bear to hold the arm still, (n, j) [Nm or N].

    The URDF's masses, and the payload as a point at the flange's origin.

    Args:
        robot: The arm.
        q: Joint values, (n, j) [rad or m].
        payload_kg: Mass at the flange in each pose, (n,) [kg]; None for none.
    """
    own = robot.gravity_torques(q)
    return own if payload_kg is None else own + payload_kg[:, None] * torques_of_one_kg(robot, q)


def carried_masses(robot: Robot, q: Array, payload_kg: Array | None) -> tuple[Array, Array]:
    """The mass that each joint carries and its first moment Σ m r about the base's origin, in the base frame.

    Args:
        robot: The arm.
        q: Joint values, (n, j) [rad or m].
        payload_kg: Mass at the flange's origin in each pose, (n,) [kg]; None for none.

    Returns:
        (n, j) [kg] and (n, j, 3) [kg m].
    """
    mass, centre = robot.carried(q)
    masses = np.tile(mass, (len(q), 1))
    first_moment = masses[..., None] * centre
    if payload_kg is not None:
        chain = list(robot.chain)
        masses[:, chain] += payload_kg[:, None]
        first_moment[:, chain] += (payload_kg[:, None] * robot.forward(q[None])[0, :, :3, 3])[:, None]
    return masses, first_moment


def torques_of_one_kg(robot: Robot, q: Array) -> Array:
    """What each joint must bear to hold one kilogram at the flange's origin, (n, j) -> (n, j) [Nm or N]."""
    frames = robot.joint_frames(q[None])[0]
    tip = robot.forward(q[None])[0, :, :3, 3]
    chain = list(robot.chain)
    axes = np.einsum("nkab,kb->nka", frames[..., :3, :3], robot.axes[chain])
    arms = np.cross(axes, tip[:, None] - frames[..., :3, 3])
    lever = np.where(robot.prismatic[chain][:, None], axes, arms)
    torques = np.zeros_like(q)
    torques[:, chain] = -(lever @ np.array(robot.gravity))
    return torques
