"""Gravity loads of an arm's joints and links, payload included."""

from dataclasses import dataclass, field
from functools import cached_property
from typing import final

import numpy as np

from robolaser.arrays import Array
from robolaser.geometry.rigid_motion import exp_so3
from robolaser.robot.kinematics import Robot


@final
@dataclass(frozen=True)
class LinkLoad:
    """The load of the link before a joint, in the frame of that joint before it turns."""

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


@final
@dataclass(frozen=True, eq=False)
class Loads:
    """Loads of an arm in some poses: the URDF's masses, and the payload as a point at the flange's origin."""

    robot: Robot
    q: Array  # joint values, (n, j) [rad or m]
    payload_kg: Array | None  # mass at the flange in each pose, (n,) [kg]; None for none
    _of_links: dict[str, LinkLoad] = field(default_factory=dict, init=False)

    @cached_property
    def gravity_torques(self) -> Array:
        """Torque of each joint that holds the arm still, (n, j) [Nm or N]."""
        own = self.robot.gravity_torques(self.q)
        return own if self.payload_kg is None else own + self.payload_kg[:, None] * self.torques_of_one_kg

    @cached_property
    def torques_of_one_kg(self) -> Array:
        """Torque of each joint that holds one kilogram at the flange's origin, (n, j) [Nm or N]."""
        lever = self.robot.jacobian(self.q[None])[0, :, :3]
        return np.asarray(-np.einsum("nxj,x->nj", lever, np.array(self.robot.gravity)))

    @cached_property
    def joint_frames(self) -> Array:
        """T_base_joint of the chain's joints, each turned by its value, (n, len(chain), 4, 4)."""
        return np.asarray(self.robot.joint_frames(self.q[None])[0])

    @cached_property
    def tip(self) -> Array:
        """The flange's origin in the base frame, (n, 3) [m]."""
        return np.asarray(self.robot.forward(self.q[None])[0, :, :3, 3])

    @cached_property
    def carried(self) -> tuple[Array, Array]:
        """The mass that each joint carries, and its first moment Σ m r about the base's origin, in the base frame.

        (n, j) [kg] and (n, j, 3) [kg m].
        """
        mass, centre = self.robot.carried(self.q)
        masses = np.tile(mass, (len(self.q), 1))
        first_moment = masses[..., None] * centre
        if self.payload_kg is not None:
            chain = list(self.robot.chain)
            masses[:, chain] += self.payload_kg[:, None]
            first_moment[:, chain] += (self.payload_kg[:, None] * self.tip)[:, None]
        return masses, first_moment

    @cached_property
    def overturning_moment(self) -> Array:
        """The moment of all moving weight about the base's origin, in the base frame, (n, 3) [Nm]."""
        return np.asarray(np.cross(self.carried[1][:, self.robot.chain[0]], np.array(self.robot.gravity)))

    def of_link(self, joint: str) -> LinkLoad:
        """The load of the link before a joint that is not the first."""
        if joint in self._of_links:
            return self._of_links[joint]
        robot, masses, first_moments = self.robot, *self.carried
        at = robot.chain.index(robot.joints.index(joint))
        before, here, frames = robot.chain[at - 1], robot.chain[at], self.joint_frames
        placement, turn = robot.placements[here], 0.0 if robot.prismatic[here] else 1.0
        R_base_joint = frames[:, at, :3, :3] @ exp_so3(-turn * self.q[:, here, None] * robot.axes[here])
        mass, own_mass = masses[:, [here]], masses[:, [before]] - masses[:, [here]]
        origin = frames[:, at, :3, 3]

        def inside(vectors: Array) -> Array:
            return np.asarray(np.einsum("nba,nb->na", R_base_joint, np.broadcast_to(vectors, origin.shape)))

        self._of_links[joint] = LinkLoad(
            mass=mass,
            first_moment=inside(first_moments[:, here] - mass * origin),
            own_mass=own_mass,
            own_first_moment=inside(first_moments[:, before] - first_moments[:, here] - own_mass * origin),
            link=placement[:3, :3].T @ placement[:3, 3],
            tip=inside(self.tip - origin),
            gravity=inside(np.array(robot.gravity)),
        )
        return self._of_links[joint]
