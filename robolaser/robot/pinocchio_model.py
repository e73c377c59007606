"""An arm's Pinocchio model: one pass over the configurations gives all frames.

Pinocchio's results are read from its own memory, because a Python object for each frame would take ten times as long
as the kinematics. Its regressors refuse joints that follow others (mimic), so these are independent joints in it, with
values ratios q + offsets of the joints that are read, and derivatives follow by the chain rule.
"""

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from functools import cached_property
from threading import Lock
from typing import Any, final

import numpy as np

from robolaser.arrays import Array
from robolaser.geometry.rigid_motion import inverse


@final
@dataclass(frozen=True, eq=False)
class Link:
    """A link of the URDF on the one that carries it; all joints at zero."""

    name: str
    parent: str  # "" for the root
    T_parent_link: Array  # (4, 4)
    joint: int | None  # its joint on its parent, as one of `PinocchioModel.moving`; None: it is fixed


@final
class PinocchioModel:
    """The joints that move in an arm, m, by the values of the j joints that are read.

    Args:
        model: Pinocchio's own; each of its joints has one degree of freedom.
        columns: The joints that are read, numbered as in `moving`, (j,).
        ratios: Of all joints to those that are read, (m, j).
        offsets: Of all joints where those that are read are at zero, (m,) [rad or m].
        flange: The link that carries the sensor.
    """

    def __init__(self, model: Any, columns: Sequence[int], ratios: Array, offsets: Array, flange: str) -> None:
        import pinocchio  # noqa: PLC0415 - loaded only for data sets with an arm that is computed

        self._pinocchio = pinocchio
        self.model, self.columns, self.ratios, self.offsets = model, list(columns), ratios, offsets
        self.moving: tuple[str, ...] = tuple(model.names)[1:]  # the joints that move, those that carry others first
        self.parents = np.array(model.parents)[1:] - 1  # the joint that carries each, (m,); -1 for the base
        self._flange = model.getFrameId(flange, pinocchio.BODY)
        frame = model.frames[self._flange]
        self.tip = frame.parentJoint - 1  # the last joint that carries the flange
        self.end = np.array(frame.placement.homogeneous)  # from it to the flange, (4, 4)
        self.way = np.zeros(len(self.moving))
        self.way[np.array(model.supports[frame.parentJoint])[1:] - 1] = 1.0
        """One for each joint that carries the flange, (m,)."""
        moved = (int(column) for joint in np.flatnonzero(self.way) for column in np.flatnonzero(ratios[joint]))
        self.chain = tuple(dict.fromkeys(moved))  # the joints read that move the flange, from base to flange
        self._endless = np.array(model.nqs)[1:] == 2
        self.placements = _poses(np.array(_view(model.jointPlacements)[1:]))
        """Of each joint on the one that carries it, or the base, (m, 4, 4)."""
        self.masses = np.array([one.mass for one in model.inertias])[1:]
        """Of what each joint moves, up to the next joints, (m,) [kg]."""
        self.centres = np.array([one.lever for one in model.inertias])[1:]
        """Centres of these masses, in the frames of the joints, (m, 3) [m]."""
        self._data, self._moved, self._lock = model.createData(), model.copy(), Lock()
        self._moved_data = self._moved.createData()
        at_rest, jacobian = pinocchio.neutral(model), pinocchio.computeJointJacobian
        own = [jacobian(model, self._data, at_rest, i + 1).reshape(6, -1)[:, i] for i in range(len(self.moving))]
        self.slides = np.array([column[:3].any() for column in own])  # whether each joint is prismatic, (m,)
        self.axes = np.array([column[:3] + column[3:] for column in own])  # of a joint, one of them is zero
        """Unit axis of each joint in its frame, (m, 3)."""

    @property
    def limits(self) -> tuple[Array, Array]:
        """Least and largest value of each joint, (m,) and (m,) [rad or m]; infinite for continuous joints."""
        first = np.array(self.model.idx_qs)[1:]
        lower, upper = self.model.lowerPositionLimit[first], self.model.upperPositionLimit[first]
        return np.where(self._endless, -np.inf, lower), np.where(self._endless, np.inf, upper)

    @cached_property
    def links(self) -> tuple[Link, ...]:
        """The links of the URDF, each after the one that carries it."""
        frames, links = self.model.frames, []
        for frame in frames:
            if frame.type != self._pinocchio.BODY:
                continue
            joint = frames[frame.parentFrame]
            parent, moves = frames[joint.parentFrame], joint.type == self._pinocchio.JOINT
            T = self.placements[joint.parentJoint - 1] if moves else frame.placement.homogeneous
            name = parent.name if parent.type == self._pinocchio.BODY else ""
            T = inverse(parent.placement.homogeneous) @ T
            links.append(Link(frame.name, name, T, joint.parentJoint - 1 if moves else None))
        return tuple(links)

    def rows(self, q: Array) -> Array:
        """Joint values as Pinocchio has them, (..., j) -> (..., nq)."""
        values, first = q @ self.ratios.T + self.offsets, np.array(self.model.idx_qs)[1:]
        rows = np.empty((*q.shape[:-1], self.model.nq))
        rows[..., first], turn = values, values[..., self._endless]
        rows[..., first[self._endless]], rows[..., first[self._endless] + 1] = np.cos(turn), np.sin(turn)
        return rows

    def frames(self, q: Array, placements: Array | None = None) -> Array:
        """T_base_joint of all joints, each turned by its own value, (c, n, m, 4, 4).

        Args:
            q: Joint values, (c or 1, n, j) [rad] or [m].
            placements: Of the joints that are read, in place of the nominal ones, (c or 1, n or 1, j, 4, 4).
        """
        return self._computed(q, placements, slice(len(self.moving)))

    def flange(self, q: Array, placements: Array | None, *computed: Array | None) -> Array:
        """T_base_flange, (c, n, 4, 4), with the same arguments; fills in other requested arrays."""
        T = self._computed(q, placements, slice(self.tip, self.tip + 1), *computed)
        return np.asarray(T.reshape(-1, 4) @ self.end).reshape(*T.shape[:2], 4, 4)

    def flange_and_twists(
        self, q: Array, placements: Array | None, *, by_placements: bool
    ) -> tuple[Array, Array, Array | None]:
        """The same, and the twists of the flange by joints, (c, n, 6, j), and by placements, (c, n, 6, j, 6)."""
        c, n = _candidates(q, placements)
        J = np.empty((c, n, 6, len(self.moving)))
        regressors = np.empty((c, n, 6, len(self.moving), 6)) if by_placements else None
        T = self.flange(q, placements, J, regressors)
        return T, (J * self.way) @ self.ratios, None if regressors is None else regressors[:, :, :, self.columns]

    def _computed(
        self, q: Array, placements: Array | None, joints: slice, J: Array | None = None, regressors: Array | None = None
    ) -> Array:
        """T_base_joint of some joints at each posture of each candidate; fills in other requested arrays."""
        c, n = _candidates(q, placements)
        rows = np.broadcast_to(self.rows(q), (c, n, self.model.nq))
        model, data = (self.model, self._data) if placements is None else (self._moved, self._moved_data)
        if placements is not None:
            there = np.broadcast_to(self.placements, (*placements.shape[:2], *self.placements.shape)).copy()
            there[:, :, self.columns] = placements
            there = np.broadcast_to(np.swapaxes(there[..., :3, :], -1, -2), (c, *there.shape[1:3], 4, 3))
        algorithm = self._pinocchio.forwardKinematics if J is None else self._pinocchio.computeJointJacobians
        regressor, world = self._pinocchio.computeFrameKinematicRegressor, self._pinocchio.WORLD
        with self._lock:
            found, placed, jacobian = _view(data.oMi)[1:][joints], _view(model.jointPlacements), data.J.reshape(6, -1)
            frames = np.empty((c, n, *found.shape))
            for k in range(c):
                for i in range(n):
                    if placements is not None and i < placements.shape[1]:
                        placed[1:] = there[k, i]
                    algorithm(model, data, rows[k, i])
                    frames[k, i] = found
                    if J is not None:
                        J[k, i] = jacobian
                    if regressors is not None:
                        regressors[k, i] = regressor(model, data, self._flange, world).reshape(6, -1, 6)
        return _poses(frames)

    def gravity_torques(self, q: Array) -> Array:
        """Torque of each joint that is read to hold the arm still, (n, j) -> (n, j) [Nm or N]."""
        return self._torques(self._pinocchio.computeGeneralizedGravity, self.rows(q)) @ self.ratios

    def inverse_dynamics(self, q: Array, speed: Array, acceleration: Array) -> Array:
        """Torques of the joints that are read for a motion of the rigid arm, (n, j) each -> (n, j) [Nm or N]."""
        moved = self.rows(q), speed @ self.ratios.T, acceleration @ self.ratios.T
        return self._torques(self._pinocchio.rnea, *moved) @ self.ratios

    def _torques(self, algorithm: Callable[..., Array], *moved: Array) -> Array:
        """Torques of all joints by one of Pinocchio's algorithms, (n, m)."""
        torques = np.empty((len(moved[0]), len(self.moving)))
        with self._lock:
            for torque, *row in zip(torques, *moved, strict=True):
                torque[:] = algorithm(self.model, self._data, *row)
        return torques

    def inertial_numbers(self, joint: int) -> Array:
        """Inertial numbers of the load of a moving joint, by the URDF, in the order of `torque_regressor`, (10,)."""
        return np.asarray(self.model.inertias[joint + 1].toDynamicParameters())

    def torque_regressor(self, q: Array, speed: Array, acceleration: Array, joint: int) -> Array:
        """The same torques for a unit of each inertial number of a joint's load, numbered as in `moving`.

        Returns:
            (n, j, 10): of the mass, its first moments x, y, z, and the inertia xx, xy, yy, xz, yz, zz about the joint.
        """
        torques = np.empty((len(q), len(self.moving), 10))
        moved = zip(self.rows(q), speed @ self.ratios.T, acceleration @ self.ratios.T, torques, strict=True)
        with self._lock:
            for row, v, a, torque in moved:
                whole = self._pinocchio.computeJointTorqueRegressor(self.model, self._data, row, v, a)
                torque[:] = whole[:, 10 * joint : 10 * joint + 10]
        return np.asarray(np.einsum("nmk,mj->njk", torques, self.ratios))

    def carried(self, q: Array) -> tuple[Array, Array]:
        """The mass that each joint carries, (j,) [kg], and its centre in the base frame, (n, j, 3) [m]."""
        centres, frames = np.empty((len(q), self.model.njoints, 3)), np.empty((len(q), self.model.njoints, 4, 3))
        with self._lock:
            found, own = _view(self._data.oMi), _view_of_points(self._data.com)
            for row, centre, frame in zip(self.rows(q), centres, frames, strict=True):
                self._pinocchio.centerOfMass(self.model, self._data, row, True)  # noqa: FBT003 - of each subtree, too
                centre[:] = own
                frame[:] = found
            masses = np.array(self._data.mass)[1:][self.columns]
        T, at = _poses(frames[:, 1:][:, self.columns]), centres[:, 1:][:, self.columns]
        at = np.where(masses[:, None] > 0.0, at, 0.0)
        return masses, (T[..., :3, :3] @ at[..., None])[..., 0] + T[..., :3, 3]


def _candidates(q: Array, placements: Array | None) -> tuple[int, int]:
    """Numbers of candidates, and of postures of each."""
    c, n = np.broadcast_shapes(q.shape[:2], (1, 1) if placements is None else placements.shape[:2])
    return c, n


def _view(frames: Any) -> Array:
    """The memory of Pinocchio's vector of placements, (k, 4, 3): the columns of each rotation, and the shift."""
    first, second = frames[0], frames[1]
    R, t, after = (_address(part) for part in (first.rotation, first.translation, second.rotation))
    size = first.rotation.itemsize
    if t - R != 9 * size:
        raise AssertionError("Pinocchio does not store the translation of a placement right behind its rotation.")
    shape, strides = (len(frames), 4, 3), (after - R, 3 * size, size)
    return np.lib.stride_tricks.as_strided(first.rotation, shape, strides)


def _view_of_points(points: Any) -> Array:
    """The memory of Pinocchio's vector of points, (k, 3)."""
    first, second = points[0], points[1]
    return np.lib.stride_tricks.as_strided(
        first, (len(points), 3), (_address(second) - _address(first), first.itemsize)
    )


def _address(part: Array) -> int:
    return int(part.__array_interface__["data"][0])


def _poses(columns: Array) -> Array:
    """Columns of rotations and shifts, (..., 4, 3), as motions, (..., 4, 4)."""
    T = np.zeros((*columns.shape[:-2], 4, 4))
    T[..., :3, :] = np.swapaxes(columns, -1, -2)
    T[..., 3, 3] = 1.0
    return T
