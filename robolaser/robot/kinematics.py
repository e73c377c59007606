"""A serial arm: joint values to flange poses, many candidates at once, and the weight its joints carry."""

from collections import deque
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from functools import cached_property
from typing import Self, final

import numpy as np

from robolaser.arrays import Array, Bools
from robolaser.errors import RobotError
from robolaser.geometry import urdf
from robolaser.geometry.rigid_motion import exp_so3, inverse, pose, rotation_to_axis
from robolaser.geometry.urdf.markup import too_large
from robolaser.geometry.urdf.parsing import joint_kind
from robolaser.geometry.urdf.tree import MOVING, Joint, Tree, unknown_joint

DOWN = (0.0, 0.0, -9.81)  # gravity in the frame of a base that stands upright [m/s²]


@final
@dataclass(frozen=True, eq=False)
class Robot:
    """A robot as its URDF describes it; the base frame is the URDF's root link.

    Joint limits are carried, not enforced: `forward` computes outside them too; the data set checks.
    """

    name: str
    joints: tuple[str, ...]  # the moving joints, in the order of the columns of q
    flange: str  # the link that carries the sensor
    gravity: tuple[float, float, float]  # in the base frame [m/s²]
    urdf: str  # the URDF as it was read
    lower: Array  # (j,) [rad] or [m]; -inf for continuous joints
    upper: Array  # (j,) [rad] or [m]; inf for continuous joints
    placements: Array  # each joint on the listed joint (or base) before it, (j, 4, 4); unlisted ones are at neutral
    axes: Array  # unit axis in the joint frame, (j, 3)
    prismatic: Bools  # (j,)
    end: Array  # last joint of the chain to flange, (4, 4)
    chain: tuple[int, ...]  # indices into `joints` of those that move the flange, from base to flange

    @classmethod
    def from_urdf(
        cls,
        text: str,
        *,
        flange: str,
        joints: Sequence[str] | None = None,
        gravity: Sequence[float] = DOWN,
        source: str = "robot.urdf",
    ) -> Self:
        """Read a robot; joints that are not listed stay at neutral.

        Args:
            text: The URDF itself; meshes are never needed.
            flange: The link that carries the sensor.
            joints: The columns of q; when absent, all that move the flange, from base to flange.
            gravity: In the base frame, (3,) [m/s²].
            source: What error messages call the URDF.

        Raises:
            RobotError: The text is no robot; there is no such flange or no such moving joint; a joint is listed twice;
                none of the joints moves the flange; or a mimic joint on the way to the flange follows a listed one.
        """
        tree = urdf.parse(text, source=source)
        path = tree.path(flange)
        for joint in path:
            if joint.kind in ("floating", "planar"):
                raise joint_kind(source, joint.name, joint.kind, (*MOVING, "fixed"))
        listed = _listed(tree, path, joints)
        if len(listed) > urdf.MOST_JOINTS:
            raise too_large(source, "moving joints in use", urdf.MOST_JOINTS)
        index = {joint.name: i for i, joint in enumerate(listed)}
        chain = tuple(index[joint.name] for joint in path if joint.name in index)
        if not chain:
            moving = ", ".join(joint.name for joint in path if joint.moves)
            raise RobotError(
                f"{source}: none of the listed joints moves the flange '{flange}'. Joints that do: {moving or 'none'}."
            )
        for joint in path:
            if joint.name not in index and joint.follows in index:
                raise RobotError(
                    f"{source}: on the way to the flange, joint '{joint.name}' follows '{joint.follows}' (mimic), which"
                    f" robolaser does not compute. List '{joint.name}' among the joints and give its angle too."
                )
        x, y, z = (float(g) for g in gravity)
        return cls(
            name=tree.name,
            joints=tuple(index),
            flange=flange,
            gravity=(x, y, z),
            urdf=text,
            lower=np.array([joint.lower for joint in listed]),
            upper=np.array([joint.upper for joint in listed]),
            placements=np.array([_since_listed(tree.path(joint.child), index) for joint in listed]),
            axes=np.array([joint.axis for joint in listed]),
            prismatic=np.array([joint.kind == "prismatic" for joint in listed]),
            end=_fold([joint.origin for joint in path[_last(path, index) + 1 :]]),
            chain=chain,
        )

    def forward(self, q: Array, placements: Array | None = None) -> Array:
        """Where the flange is. Joint limits are not checked here.

        Args:
            q: Joint values, (c or 1, n, j) [rad] or [m].
            placements: Of the joints, in place of the nominal ones, (c or 1, n or 1, j, 4, 4).

        Returns:
            T_base_flange, (c, n, 4, 4).
        """
        last = deque(self._along(q, placements), maxlen=1)
        return _poses(last[0], self._from_axis[self.chain[-1]] @ self.end)

    def joint_frames(self, q: Array, placements: Array | None = None) -> Array:
        """Where the joints of the chain are, from base to flange, each turned by its own value.

        Args:
            q: As for `forward`.
            placements: As for `forward`.

        Returns:
            T_base_joint, (c, n, len(chain), 4, 4).
        """
        steps = zip(self.chain, self._along(q, placements), strict=True)
        return np.stack([_poses(T, self._from_axis[i]) for i, T in steps], axis=2)

    def _along(self, q: Array, placements: Array | None) -> Iterator[Array]:
        """The frames of the chain's joints, z along each axis, by columns, (c, 4, 3, n)."""
        P = self.placements[None, None] if placements is None else placements
        c, n = np.broadcast_shapes(q.shape[:2], P.shape[:2])
        values = np.ascontiguousarray(np.moveaxis(q, -1, 0))[:, :, None]
        sin, cos = np.sin(values), np.cos(values)
        T = np.broadcast_to(np.eye(4)[None, :, :3, None], (c, 4, 3, n))
        before = np.eye(4)
        for i in self.chain:
            T = _times(T, before @ P[:, :, i] @ self._to_axis[i])
            before = self._from_axis[i]
            x, y, z = T[:, 0], T[:, 1], T[:, 2]
            if self.prismatic[i]:
                T[:, 3] += values[i] * z
            else:
                T[:, 0], T[:, 1] = cos[i] * x + sin[i] * y, cos[i] * y - sin[i] * x
            yield T

    def gravity_torques(self, q: Array) -> Array:
        """What each joint must bear to hold the arm still at q, all masses of the URDF counted.

        Args:
            q: Joint values, (..., j) [rad] or [m]; unlisted joints are at neutral.

        Returns:
            Generalised gravity, (..., j) [Nm] or [N]; zeros for a URDF without masses.
        """
        frames, masses, moments = self._loads(q.reshape(-1, q.shape[-1]))
        axes = (frames[..., :3, :3] @ self.axes[..., None])[..., 0]
        lever = np.where(self.prismatic[:, None], masses[:, None] * axes, np.cross(axes, moments))
        torques: Array = -(lever @ np.array(self.gravity)).reshape(q.shape)
        return torques

    def carried(self, q: Array) -> tuple[Array, Array]:
        """The mass of all that each joint carries, by the URDF, and where its centre is.

        Args:
            q: Joint values, (n, j) [rad] or [m]; unlisted joints are at neutral.

        Returns:
            Masses (j,) [kg] and centres in the base frame (n, j, 3) [m]; where there is no mass, the joint's origin.
        """
        frames, masses, moments = self._loads(q)
        return masses, frames[..., :3, 3] + moments / np.where(masses > 0.0, masses, 1.0)[:, None]

    def _loads(self, q: Array) -> tuple[Array, Array, Array]:
        """What the listed joints carry at q (n, j).

        Returns:
            T_base_joint, each turned by its own value, (n, j, 4, 4); masses (j,) [kg]; and their first moments about
            the joint's origin, along the axes of the base, (n, j, 3) [kg m].
        """
        before, masses, moments = self._bodies
        frames = np.empty((*q.shape, 4, 4))
        for i in before:
            along = q[:, [i]] * self.axes[i]
            motion = pose(np.eye(3), along) if self.prismatic[i] else pose(exp_so3(along), np.zeros(3))
            base = np.eye(4) if before[i] is None else frames[:, before[i]]
            frames[:, i] = base @ self.placements[i] @ motion
        masses, moments = masses.copy(), (frames[..., :3, :3] @ moments[..., None])[..., 0]
        for i in reversed(before):
            if (carrier := before[i]) is not None:
                moments[:, carrier] += moments[:, i] + masses[i] * (frames[:, i] - frames[:, carrier])[:, :3, 3]
                masses[carrier] += masses[i]
        return frames, masses, moments

    @cached_property
    def _tree(self) -> Tree:
        return urdf.parse(self.urdf)

    @cached_property
    def _bodies(self) -> tuple[dict[int, int | None], Array, Array]:
        """The listed joint before each, from the base on; and mass and first moment of what each alone carries.

        Both as `_loads` has them, (j,) and (j, 3), but along the axes of the joint.
        """
        tree, index = self._tree, {name: i for i, name in enumerate(self.joints)}
        masses, moments = np.zeros(len(index)), np.zeros((len(index), 3))
        for link in tree.links.values():
            path = tree.path(link.name)
            if (last := _last(path, index)) >= 0:
                T = _fold([joint.origin for joint in path[last + 1 :]])
                masses[index[path[last].name]] += link.mass
                moments[index[path[last].name]] += link.mass * (T[:3, :3] @ link.com + T[:3, 3])
        before: dict[int, int | None] = {}
        for path in sorted((tree.path(tree.joints[name].child) for name in index), key=len):
            last = _last(path[:-1], index)
            before[index[path[-1].name]] = None if last < 0 else index[path[last].name]
        return before, masses, moments

    @cached_property
    def has_masses(self) -> bool:
        """Whether any link that a listed joint moves has a mass."""
        return bool(self._bodies[1].any())

    def urdf_with(self, placements: Array) -> str:
        """Write the URDF with the joints placed anew, (j, 4, 4), as `placements` means them."""
        tree = self._tree
        shift = inverse(self.placements) @ placements
        return urdf.with_placements(
            self.urdf,
            {
                name: tree.joints[name].origin @ shift[i]
                for i, name in enumerate(self.joints)
                if not np.array_equal(placements[i], self.placements[i])
            },
        )

    @cached_property
    def _to_axis(self) -> Array:
        """Turns that lay z along each joint's axis, (j, 4, 4): about z, turning is two columns mixed."""
        return pose(np.array([rotation_to_axis(axis) for axis in self.axes]), np.zeros((len(self.axes), 3)))

    @cached_property
    def _from_axis(self) -> Array:
        return inverse(self._to_axis)


def _times(T: Array, P: Array) -> Array:
    """T @ P, for P (c or 1, n or 1, 4, 4) and T by columns, (c, 4, 3, n): long rows multiply fast."""
    if P.shape[1] == 1:
        product: Array = np.swapaxes(P[:, 0], -1, -2) @ T.reshape(T.shape[0], 4, -1)
        return product.reshape(T.shape)
    columns = np.ascontiguousarray(np.moveaxis(P, 1, -1))[:, :, :, None]
    return np.stack([(columns[:, :, i] * T).sum(axis=1) for i in range(4)], axis=1)


def _poses(T: Array, onward: Array) -> Array:
    """T @ onward, for T by columns, (c, 4, 3, n), and one `onward` (4, 4), -> (c, n, 4, 4)."""
    out = np.zeros((T.shape[0], T.shape[3], 4, 4))
    out[..., :3, :] = np.moveaxis(_times(T, onward[None, None]), 3, 1).swapaxes(-1, -2)
    out[..., 3, 3] = 1.0
    return out


def _listed(tree: Tree, path: list[Joint], names: Sequence[str] | None) -> list[Joint]:
    if names is None:
        return [joint for joint in path if joint.moves and joint.follows is None]
    for i, name in enumerate(names):
        if name not in tree.joints or not tree.joints[name].moves:
            raise unknown_joint(tree.source, name, [j.name for j in tree.joints.values() if j.moves])
        if name in names[:i]:
            raise RobotError(f"Joint '{name}' of {tree.source} is listed twice. List each joint once.")
    return [tree.joints[name] for name in names]


def _last(path: list[Joint], index: dict[str, int]) -> int:
    return max((i for i, joint in enumerate(path) if joint.name in index), default=-1)


def _since_listed(path: list[Joint], index: dict[str, int]) -> Array:
    return _fold([joint.origin for joint in path[_last(path[:-1], index) + 1 :]])


def _fold(origins: list[Array]) -> Array:
    T = np.eye(4)
    for origin in origins:
        T = T @ origin
    return T
