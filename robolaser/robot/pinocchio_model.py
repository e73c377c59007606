"""An arm's Pinocchio model: one pass over the configurations gives all frames.

Pinocchio's answers are read from its own memory, because a Python object for each frame would take ten times as long
as the kinematics.
"""

from threading import Lock
from typing import Any, final

import numpy as np

from robolaser.arrays import Array


@final
class PinocchioModel:
    """The arm of a URDF that was checked; joints are numbered as in it, from 0.

    Args:
        text: A URDF whose moving joints are `joint_0`, `joint_1` and so on, each turned or moved by one number.
        flange: The link that carries the sensor.
        gravity: In the base frame, (3,) [m/s²].
    """

    def __init__(self, text: str, flange: str, gravity: tuple[float, float, float]) -> None:
        import pinocchio  # noqa: PLC0415 - loaded only for data sets with an arm that is computed

        self._pinocchio = pinocchio
        self.model = pinocchio.buildModelFromXML(text)
        """Pinocchio's own, with the nominal placements."""
        self.model.gravity.linear = np.array(gravity)
        self.joints = np.array([self.model.getJointId(f"joint_{i}") for i in range(self.model.njoints - 1)])
        """Pinocchio's number of each joint, (j,)."""
        self.end = np.array(self.model.frames[self.model.getFrameId(flange, pinocchio.BODY)].placement.homogeneous)
        """From the last joint that moves the flange, or the base, to the flange, (4, 4)."""
        self.masses = np.array([one.mass for one in self.model.inertias])[self.joints]
        """Mass of what each joint carries, up to the next joints, (j,) [kg]."""
        self._data, self._moved = self.model.createData(), self.model.copy()
        self._moved_data, self._lock = self._moved.createData(), Lock()

    @property
    def placements(self) -> Array:
        """Of each joint on the joint, or base, before it, (j, 4, 4)."""
        return _poses(np.array(_view(self.model.jointPlacements)[self.joints]))

    @property
    def axes(self) -> Array:
        """Unit axis of each joint in its frame, (j, 3)."""
        at_rest, jacobian = self._pinocchio.neutral(self.model), self._pinocchio.computeJointJacobian
        with self._lock:
            own = [jacobian(self.model, self._data, at_rest, i)[:, self.model.idx_vs[i]] for i in self.joints.tolist()]
        return np.array([column[:3] + column[3:] for column in own])  # of a joint, one of them is zero

    def frames(self, q: Array, placements: Array | None = None) -> Array:
        """T_base_joint of all joints, each turned by its own value, (c, n, j, 4, 4).

        Args:
            q: Joint values, (c or 1, n, j) [rad] or [m].
            placements: Of the joints, in place of the nominal ones, (c or 1, n or 1, j, 4, 4).
        """
        return self._computed(self._pinocchio.forwardKinematics, q, placements, None)

    def frames_and_twists(self, q: Array, placements: Array | None = None) -> tuple[Array, Array]:
        """The same, and the velocity with which each joint carries what is at the base's origin, (c, n, 6, j).

        The velocity, then the angular velocity, per unit speed of the joint, in the base frame.
        """
        twists = np.empty((*_candidates(q, placements), 6, self.model.nv))
        frames = self._computed(self._pinocchio.computeJointJacobians, q, placements, twists)
        return frames, twists[..., np.array(self.model.idx_vs)[self.joints]]

    def _computed(self, algorithm: Any, q: Array, placements: Array | None, twists: Array | None) -> Array:
        """T_base_joint of all joints at each posture of each candidate; fills in their twists where these are asked."""
        c, n = _candidates(q, placements)
        rows = np.broadcast_to(self._rows(q), (c, n, q.shape[-1]))
        frames = np.empty((c, n, self.model.njoints, 4, 3))
        model, data = (self.model, self._data) if placements is None else (self._moved, self._moved_data)
        if placements is not None:
            there = np.zeros((*placements.shape[:2], self.model.njoints, 4, 3))
            there[:, :, 0, :3] = np.eye(3)
            there[:, :, self.joints] = np.swapaxes(placements[..., :3, :], -1, -2)
            there = np.broadcast_to(there, (c, *there.shape[1:]))
        with self._lock:
            found, placed, columns = _view(data.oMi), _view(model.jointPlacements), data.J
            for k in range(c):
                for i in range(n):
                    if placements is not None and i < placements.shape[1]:
                        placed[:] = there[k, i]
                    algorithm(model, data, rows[k, i])
                    frames[k, i] = found
                    if twists is not None:
                        twists[k, i] = columns
        return _poses(frames[:, :, self.joints])

    def gravity_torques(self, q: Array) -> Array:
        """What each joint must bear to hold the arm still, (n, j) -> (n, j) [Nm or N]."""
        torques = np.empty(q.shape)
        with self._lock:
            for row, torque in zip(self._rows(q), torques, strict=True):
                torque[:] = self._pinocchio.computeGeneralizedGravity(self.model, self._data, row)
        return torques[:, np.array(self.model.idx_vs)[self.joints]]

    def carried(self, q: Array) -> tuple[Array, Array]:
        """The mass that each joint carries, (j,) [kg], and where its centre is in the base frame, (n, j, 3) [m]."""
        centres, frames = np.empty((len(q), self.model.njoints, 3)), np.empty((len(q), self.model.njoints, 4, 3))
        with self._lock:
            found, own = _view(self._data.oMi), _view_of_points(self._data.com)
            for row, centre, frame in zip(self._rows(q), centres, frames, strict=True):
                self._pinocchio.centerOfMass(self.model, self._data, row, True)  # noqa: FBT003 - of each subtree, too
                centre[:] = own
                frame[:] = found
            masses = np.array(self._data.mass)[self.joints]
        T, centres = _poses(frames[:, self.joints]), np.where(masses[:, None] > 0.0, centres[:, self.joints], 0.0)
        return masses, (T[..., :3, :3] @ centres[..., None])[..., 0] + T[..., :3, 3]

    def _rows(self, q: Array) -> Array:
        """Joint values in Pinocchio's order."""
        rows = np.empty(q.shape)
        rows[..., np.array(self.model.idx_qs)[self.joints]] = q
        return rows


def _candidates(q: Array, placements: Array | None) -> tuple[int, int]:
    """How many candidates, and postures of each, there are."""
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
