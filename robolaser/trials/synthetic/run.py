"""A run of the cell: where the arm was told to stand, when, how fast it passed, above what, and what its parts bore."""

from dataclasses import dataclass
from typing import final

import numpy as np

from robolaser.arrays import Array, Ints
from robolaser.errors import RobotError
from robolaser.geometry.rigid_motion import apply, exp_so3
from robolaser.robot.kinematics import Robot

SCANNER_AT = np.array([0.06, 0.0, 0.04])  # centre of the payload in the flange frame [m]


@final
@dataclass(frozen=True)
class SyntheticRun:
    """What a fault may depend on."""

    robot: Robot  # the nominal arm
    q: Array  # joint angles as read, (n, j) [rad or m]
    qd: Array  # velocities at the reading, (n, j) [rad/s or m/s]
    time: Array  # of each pose, (n,) [s]
    middle: Array  # of the target, (3,) in the base frame [m]
    radius: float  # of the part of the target that is looked at [m]
    payload_kg: float  # what the flange carries; the URDF does not know of it

    def __post_init__(self) -> None:
        """Raise a `RobotError` for an arm some of whose joints follow others."""
        if len(self.robot.by_pinocchio.moving) > len(self.robot.joints):
            raise RobotError(f"{self.robot.name} has joints that follow others (mimic): trials cannot move it yet.")

    @property
    def joints(self) -> tuple[str, ...]:
        """Those that move the flange, base first."""
        return tuple(self.robot.joints[i] for i in self.robot.chain)

    @property
    def share(self) -> Array:
        """How far the run is, 0 to 1, (n,)."""
        return np.asarray((self.time - self.time.min()) / max(1e-9, float(np.ptp(self.time))))

    @property
    def order(self) -> Ints:
        """The poses as they came, (n,)."""
        return np.argsort(self.time, kind="stable")

    def column(self, joint: str) -> int:
        """The column of a joint in q."""
        return self.robot.joints.index(joint)

    def torques(self, payload_kg: float) -> Array:
        """What each joint bears with a payload on the flange, (n, j) [Nm or N]."""
        lift = self.robot.jacobian(self.q, self._payload_at)[:, :3]
        payload = payload_kg * np.einsum("nij,i->nj", lift, self.robot.gravity)
        return np.asarray(self.robot.gravity_torques(self.q) - payload)

    def relative_torque(self, joint: str) -> Array:
        """What a joint bears, the payload counted, over the most that it bears in the run, (n,)."""
        torque = self.torques(self.payload_kg)[:, self.column(joint)]
        return np.asarray(torque / max(1e-9, float(np.abs(torque).max())))

    def overturning(self) -> Array:
        """What the mount must bear of all that moves: its moment about the base's origin, base frame, (n, 3) [Nm]."""
        return self._borne(self.robot.chain[0], self.payload_kg)[1]

    def link_loads(self, joint: str, payload_kg: float) -> tuple[Array, Array]:
        """The weight beyond a joint and its moment about it, in its frame before it turns, (n, 3) [N] and [Nm]."""
        i, robot = self.column(joint), self.robot
        T = robot.joint_frames(self.q)[:, robot.chain.index(i)]
        weight, moment = self._borne(i, payload_kg)
        R = T[:, :3, :3] @ exp_so3(-self.q[:, [i]] * np.where(robot.prismatic[i], 0.0, robot.axes[i]))
        loads = weight, moment - np.cross(T[:, :3, 3], weight)
        force, about = (np.einsum("nba,nb->na", R, np.broadcast_to(load, T[:, :3, 3].shape)) for load in loads)
        return force, about

    @property
    def _payload_at(self) -> Array:
        """Its centre in the base frame, (n, 3) [m]."""
        return apply(self.robot.forward(self.q), SCANNER_AT)

    def _borne(self, column: int, payload_kg: float) -> tuple[Array, Array]:
        """The weight beyond a joint that moves the flange, (3,) [N], and its moment about the base, (n, 3) [Nm]."""
        gravity, (masses, centres) = np.array(self.robot.gravity), self.robot.carried(self.q)
        first_moment = masses[column] * centres[:, column] + payload_kg * self._payload_at
        return (masses[column] + payload_kg) * gravity, np.cross(first_moment, gravity)

    def warmed(self, tau: float) -> Array:
        """0 at the start, towards 1 with a time constant, a share of the run, (n,)."""
        return 1.0 - np.exp(-self.share / tau)
