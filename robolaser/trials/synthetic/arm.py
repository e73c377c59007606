"""A serial arm as a product of exponentials: flange poses, weights and lever arms, independent of the package's arm.

Lynch, Park 2017, Modern Robotics, ch. 4.1.
"""

from typing import final

import numpy as np

from robolaser.arrays import Array
from robolaser.errors import RobotError
from robolaser.geometry.rigid_motion import apply, exp_so3, pose
from robolaser.robot.kinematics import Robot

SCANNER_AT = np.array([0.06, 0.0, 0.04])  # centre of the payload in the flange frame [m]


@final
class ScrewArm:
    """The arm of a URDF with its links."""

    def __init__(self, robot: Robot) -> None:
        arm = robot.by_pinocchio
        self.robot = robot  # nominal
        self.joints = tuple(robot.joints[i] for i in robot.chain)  # those that move the flange, base first
        self.columns = tuple(robot.chain)  # column of each in q
        self.count = len(robot.joints)
        self._turns, self._axes = ~robot.prismatic, robot.axes
        self.links = robot.placements  # placement of each joint on the joint before it, (j, 4, 4)
        if len(arm.moving) > self.count:
            raise RobotError(f"{robot.name} has joints that follow others (mimic): trials cannot move it yet.")
        read = {number: column for column, number in enumerate(arm.columns)}
        self._before = {read[number]: read.get(int(arm.parents[number])) for number in range(self.count)}
        self._tip, self._end = read[arm.tip], robot.end
        self._bodies = [(read[number], arm.masses[number], arm.centres[number]) for number in range(self.count)]

    def _frames(self, q: Array, links: Array | None = None) -> Array:
        """T_base_joint of all joints after their rotation, (n, j, 4, 4)."""
        links = self.links[None] if links is None else links
        frames = np.empty((*q.shape, 4, 4))
        for i, before in self._before.items():
            along = q[:, [i]] * self._axes[i]
            screw = pose(exp_so3(along), np.zeros(3)) if self._turns[i] else pose(np.eye(3), along)
            frames[:, i] = (np.eye(4) if before is None else frames[:, before]) @ links[:, i] @ screw
        return frames

    def forward(self, q: Array, links: Array | None = None) -> Array:
        """T_base_flange, (n, 4, 4), of postures (n, j) [rad or m], each with its links, (n, j, 4, 4)."""
        return np.asarray(self._frames(q, links)[:, self._tip] @ self._end)

    def _borne(self, frames: Array, payload_kg: float) -> tuple[Array, Array]:
        """The weight beyond each joint, (j, 3) [N], and its moment about it, (n, j, 3) [Nm], in the base frame."""
        masses, moments = np.zeros(self.count), np.zeros((*frames.shape[:2], 3))
        for last, mass, centre in [*self._bodies, (self._tip, payload_kg, apply(self._end, SCANNER_AT))]:
            at: Array = frames[:, last, :3, :3] @ centre + frames[:, last, :3, 3]
            carrier: int | None = last
            while carrier is not None:
                masses[carrier] += mass
                moments[:, carrier] += mass * at
                carrier = self._before[carrier]
        gravity = np.array(self.robot.gravity)
        about = moments - masses[:, None] * frames[..., :3, 3]
        return masses[:, None] * gravity, np.cross(about, gravity)

    def torques(self, q: Array, payload_kg: float) -> Array:
        """Load of each joint, with the payload on the flange, (n, j) -> (n, j) [Nm or N]."""
        frames = self._frames(q)
        weights, moments = self._borne(frames, payload_kg)
        axes = (frames[..., :3, :3] @ self._axes[..., None])[..., 0]
        return np.asarray(-(axes * np.where(self._turns[:, None], moments, weights)).sum(axis=-1))

    def overturning(self, q: Array, payload_kg: float) -> Array:
        """Moment of all moving masses about the base's origin, base frame, (n, 3) [Nm]."""
        frames, first = self._frames(q), self.columns[0]
        weights, moments = self._borne(frames, payload_kg)
        return np.asarray(moments[:, first] + np.cross(frames[:, first, :3, 3], weights[first]))

    def link_loads(self, q: Array, payload_kg: float, joint: str) -> tuple[Array, Array]:
        """The weight beyond a joint and its moment about it, in its frame before it turns, (n, 3) [N] and [Nm]."""
        frames, i = self._frames(q), self.robot.joints.index(joint)
        weights, moments = self._borne(frames, payload_kg)
        before = self._before[i]
        R = (np.eye(4) if before is None else frames[:, before])[..., :3, :3] @ self.links[i, :3, :3]
        R = np.broadcast_to(R, (len(q), 3, 3))
        return np.einsum("nba,b->na", R, weights[i]), np.einsum("nba,nb->na", R, moments[:, i])

    def levers(self, q: Array) -> Array:
        """Velocity of the flange's origin for a unit speed of each joint, base frame, (n, j) -> (n, 3, j)."""
        frames, levers = self._frames(q), np.zeros((len(q), 3, self.count))
        tip = (frames[:, self._tip] @ self._end)[:, :3, 3]
        for i in self.columns:
            axis = frames[:, i, :3, :3] @ self._axes[i]
            levers[:, :, i] = np.cross(axis, tip - frames[:, i, :3, 3]) if self._turns[i] else axis
        return levers
