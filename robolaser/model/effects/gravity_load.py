"""Torques that an arm's joints bear under gravity, the payload's weight included."""

from dataclasses import dataclass
from typing import final

import numpy as np

from robolaser.arrays import Array
from robolaser.geometry.rigid_motion import exp_so3
from robolaser.robot.kinematics import Robot


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


@final
@dataclass(frozen=True)
class LinkLoad:
    """What hangs on the link before a joint, in the frame of that joint before it turns."""

    mass: Array  # of all that the joint carries, (n, 1) [kg]
    first_moment: Array  # the same times where its centre is, (n, 3) [kg m]
    own_mass: Array  # of the link, and of what else it carries, (n, 1) [kg]
    own_first_moment: Array  # the same times where its centre is, (n, 3) [kg m]
    link: Array  # from the joint before to this one, (3,) [m]
    tip: Array  # from the joint to the flange's origin, (n, 3) [m]
    gravity: Array  # (n, 3) [m/s²]

    def moment(self, beyond: Array, payload_kg: Array) -> Array:
        """The moment of the weight beyond a point of the link about it, (c, 1, 1) -> (c, n, 3) [Nm].

        Args:
            beyond: Share of the link that is beyond the point, from 0, at the joint, to 1, at the joint before.
            payload_kg: A further mass at the flange's origin.
        """
        mass = self.mass + payload_kg + beyond * self.own_mass
        first_moment = self.first_moment + payload_kg * self.tip + beyond * (self.own_first_moment + mass * self.link)
        return np.cross(first_moment, self.gravity)


def link_load(robot: Robot, q: Array, frames: Array, tip: Array, carried: tuple[Array, Array], at: int) -> LinkLoad:
    """What hangs on the link before a joint, where there is one before it.

    Args:
        robot: The arm.
        q: Joint values, (n, j) [rad or m].
        frames: T_base_joint of the chain's joints, each turned, (n, len(chain), 4, 4).
        tip: The flange's origin in the base frame, (n, 3) [m].
        carried: As `carried_masses` gives it.
        at: The joint's place in the chain, 1 or more.
    """
    before, here = robot.chain[at - 1], robot.chain[at]
    placement, turn = robot.placements[here], 0.0 if robot.prismatic[here] else 1.0
    R_base_joint = frames[:, at, :3, :3] @ exp_so3(-turn * q[:, here, None] * robot.axes[here])
    masses, first_moments = carried
    mass, own_mass = masses[:, [here]], masses[:, [before]] - masses[:, [here]]
    origin = frames[:, at, :3, 3]

    def inside(vectors: Array) -> Array:
        return np.asarray(np.einsum("nba,nb->na", R_base_joint, np.broadcast_to(vectors, origin.shape)))

    return LinkLoad(
        mass=mass,
        first_moment=inside(first_moments[:, here] - mass * origin),
        own_mass=own_mass,
        own_first_moment=inside(first_moments[:, before] - first_moments[:, here] - own_mass * origin),
        link=placement[:3, :3].T @ placement[:3, 3],
        tip=inside(tip - origin),
        gravity=inside(np.array(robot.gravity)),
    )


def torques_of_one_kg(robot: Robot, q: Array) -> Array:
    """What each joint must bear to hold one kilogram at the flange's origin, (n, j) -> (n, j) [Nm or N]."""
    lever = robot.jacobian(q[None])[0, :, :3]
    return np.asarray(-np.einsum("nxj,x->nj", lever, np.array(robot.gravity)))
