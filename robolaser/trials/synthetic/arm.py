"""A serial arm as Pinocchio sees it: flange poses, weights and lever arms, posture by posture."""

from typing import Any, final

import numpy as np
import pinocchio

from robolaser.arrays import Array
from robolaser.robot.kinematics import Robot


@final
class PinocchioArm:
    """The arm of a URDF, links and all.

    Args:
        robot: Names the URDF, the joints that are read and the flange.
    """

    def __init__(self, robot: Robot) -> None:
        self.robot = robot
        """As drawn."""
        self.joints = tuple(robot.joints[i] for i in robot.chain)
        """Those that move the flange, base first."""
        self.columns = tuple(robot.chain)
        """Where each of them stands in q."""
        self.count = len(robot.joints)
        self._model = pinocchio.buildModelFromXML(robot.urdf)
        self._model.gravity.linear = np.array(robot.gravity)
        self._data = self._model.createData()
        self._ids = [self._model.getJointId(name) for name in robot.joints]
        self._flange = self._model.getFrameId(robot.flange, pinocchio.BODY)

    @property
    def links(self) -> Array:
        """Placement of each joint on the link before it, (j, 4, 4)."""
        return np.array([self._model.jointPlacements[i].homogeneous for i in self._ids])

    def forward(self, q: Array, links: Array | None = None) -> Array:
        """T_base_flange, (n, 4, 4), of postures (n, j) [rad or m] with links of their own, (n, j, 4, 4)."""
        kept = [pinocchio.SE3(self._model.jointPlacements[i]) for i in self._ids]
        T = np.empty((len(q), 4, 4))
        for row, posture in enumerate(q):
            if links is not None:
                for i, link in zip(self._ids, links[row], strict=True):
                    self._model.jointPlacements[i] = pinocchio.SE3(link)
            pinocchio.framesForwardKinematics(self._model, self._data, self._full(posture))
            T[row] = self._data.oMf[self._flange].homogeneous
        for i, link in zip(self._ids, kept, strict=True):
            self._model.jointPlacements[i] = link
        return T

    def torques(self, q: Array, payload_kg: float) -> Array:
        """What each joint bears, the payload on the flange counted, (n, j) -> (n, j) [Nm or N]."""
        model = self._loaded(payload_kg)
        data = model.createData()
        at = [model.joints[i].idx_v for i in self._ids]
        weights = [pinocchio.computeGeneralizedGravity(model, data, self._full(row))[at] for row in q]
        return np.array(weights)

    def overturning(self, q: Array, payload_kg: float) -> Array:
        """What the mount must bear of all that moves: its moment about the base's origin, base frame, (n, 3) [Nm]."""
        model = self._loaded(payload_kg)
        data = model.createData()
        first = self._ids[self.columns[0]]
        at_rest = np.zeros(model.nv)
        moments = np.empty((len(q), 3))
        for row, posture in enumerate(q):
            full = self._full(posture)
            pinocchio.forwardKinematics(model, data, full)
            pinocchio.rnea(model, data, full, at_rest, at_rest)
            moments[row] = -data.oMi[first].act(data.f[first]).angular
        return moments

    def link_loads(self, q: Array, payload_kg: float, joint: str) -> tuple[Array, Array]:
        """The weight beyond a joint and its moment about it, in its frame before it turns, (n, 3) [N] and [Nm]."""
        model = self._loaded(payload_kg)
        data = model.createData()
        at, at_rest = model.getJointId(joint), np.zeros(model.nv)
        force, moment = np.empty((len(q), 3)), np.empty((len(q), 3))
        for row, posture in enumerate(q):
            full = self._full(posture)
            pinocchio.forwardKinematics(model, data, full)
            pinocchio.rnea(model, data, full, at_rest, at_rest)
            before = (data.oMi[model.parents[at]] * model.jointPlacements[at]).rotation
            turn = before.T @ data.oMi[at].rotation
            force[row], moment[row] = -turn @ data.f[at].linear, -turn @ data.f[at].angular
        return force, moment

    @property
    def down(self) -> Array:
        """The direction of gravity in the base frame, (3,)."""
        gravity = np.array(self._model.gravity.linear)
        return np.asarray(gravity / np.linalg.norm(gravity))

    def levers(self, q: Array) -> Array:
        """Velocity of the flange's origin for a unit speed of each joint, base frame, (n, j) -> (n, 3, j)."""
        at = [self._model.joints[i].idx_v for i in self._ids]
        levers = np.empty((len(q), 3, len(at)))
        for row, posture in enumerate(q):
            full = pinocchio.computeFrameJacobian(
                self._model, self._data, self._full(posture), self._flange, pinocchio.LOCAL_WORLD_ALIGNED
            )
            levers[row] = full[:3, at]
        return levers

    def _loaded(self, payload_kg: float) -> Any:
        """The arm with a scanner on its flange."""
        model = self._model.copy()
        frame = model.frames[self._flange]
        scanner = pinocchio.Inertia(payload_kg, np.array([0.06, 0.0, 0.04]), 1e-3 * np.eye(3))
        model.inertias[frame.parentJoint] += frame.placement.act(scanner)
        return model

    def _full(self, posture: Array) -> Any:
        full = pinocchio.neutral(self._model)
        for i, value in zip(self._ids, posture, strict=True):
            joint = self._model.joints[i]
            turns_for_ever = joint.nq == 2
            full[joint.idx_q : joint.idx_q + joint.nq] = [np.cos(value), np.sin(value)] if turns_for_ever else value
        return full
