"""A robot's arm: joint values to flange poses, many candidates at once, and the weight its joints carry."""

from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property
from typing import Any, Self, final

import numpy as np

from robolaser.arrays import Array, Bools
from robolaser.errors import RobotError
from robolaser.geometry import urdf
from robolaser.geometry.rigid_motion import inverse, skew
from robolaser.geometry.urdf.markup import too_large
from robolaser.geometry.urdf.parsing import joint_kind
from robolaser.geometry.urdf.tree import MOVING, Joint, Tree, unknown_joint
from robolaser.robot import pose_inverse
from robolaser.robot.pinocchio_model import PinocchioModel

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
    prismatic: Bools  # (j,)
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
            prismatic=np.array([joint.kind == "prismatic" for joint in listed]),
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
        frames: Array = self.by_pinocchio.frames(q, placements)[:, :, self.chain[-1]]
        return frames @ self.end

    def joint_frames(self, q: Array, placements: Array | None = None) -> Array:
        """Where the joints of the chain are, from base to flange, each turned by its own value.

        Args:
            q: As for `forward`.
            placements: As for `forward`.

        Returns:
            T_base_joint, (c, n, len(chain), 4, 4).
        """
        return self.by_pinocchio.frames(q, placements)[:, :, list(self.chain)]

    def joint_frames_and_twists(self, q: Array, placements: Array | None = None) -> tuple[Array, Array]:
        """The same, and the twist of the flange per unit speed of each joint.

        Returns:
            T_base_joint, (c, n, len(chain), 4, 4); and the velocity of what is at the base's origin, then the angular
            velocity, in the base frame, (c, n, 6, j).
        """
        frames, twists = self.by_pinocchio.frames_and_twists(q, placements)
        chain = list(self.chain)
        moving: Array = np.isin(np.arange(len(self.joints)), chain) * twists
        return frames[:, :, chain], moving

    def jacobian(self, q: Array, points: Array | None = None) -> Array:
        """How a point that the flange carries moves with the joints: the geometric Jacobian in the base frame.

        Args:
            q: Joint values, (c, n, j) [rad] or [m].
            points: In the base frame, (c or 1, n, 3) [m]; absent, the flange's origin.

        Returns:
            Velocity of the point, then angular velocity, per unit speed of each joint, (c, n, 6, j); zero for joints
            that do not move the flange.
        """
        frames, twists = self.joint_frames_and_twists(q)
        points = (frames[:, :, -1] @ self.end)[..., :3, 3] if points is None else points
        return np.concatenate([twists[..., :3, :] - skew(points) @ twists[..., 3:, :], twists[..., 3:, :]], axis=-2)

    def inverse(self, T_base_flange: Array, start: Array | None = None) -> tuple[Array, Bools]:
        """Joint values within the limits that bring the flange to given poses.

        Of several solutions, the one that damped Newton steps reach first from the start; where they reach none, from
        others all over the joints' range, the same in each call.

        Args:
            T_base_flange: Poses, (n, 4, 4).
            start: Joint values where the search starts, (n, j) [rad] or [m]; absent, the middle of the joints' range.

        Returns:
            Joint values (n, j) [rad] or [m], the last ones tried where the pose was not reached, and whether each pose
            was reached, (n,): to 1e-9 m and rad. One that was not may, rarely, be reached from another start; arms of
            fewer than six joints reach few poses.
        """
        lower, upper = self.range
        middle = np.broadcast_to((lower + upper) / 2, (len(T_base_flange), len(self.joints)))
        return pose_inverse.inverse(
            lambda q: self.forward(q[None])[0],
            lambda q: self.jacobian(q[None])[0],
            T_base_flange,
            middle if start is None else start,
            (lower, upper),
        )

    @property
    def range(self) -> tuple[Array, Array]:
        """Least and most that each joint is used at, (j,) and (j,) [rad] or [m]: its limits; continuous ones, ±π."""
        lower = np.where(self.prismatic, self.lower, np.maximum(self.lower, np.minimum(-np.pi, self.upper - np.pi)))
        upper = np.where(self.prismatic, self.upper, np.minimum(self.upper, np.maximum(np.pi, lower + np.pi)))
        return lower, upper

    def gravity_torques(self, q: Array) -> Array:
        """What each joint must bear to hold the arm still at q, all masses of the URDF counted.

        Args:
            q: Joint values, (..., j) [rad] or [m]; unlisted joints are at neutral.

        Returns:
            Generalised gravity, (..., j) [Nm] or [N]; zeros for a URDF without masses.
        """
        return self.by_pinocchio.gravity_torques(q.reshape(-1, q.shape[-1])).reshape(q.shape)

    def carried(self, q: Array) -> tuple[Array, Array]:
        """The mass of all that each joint carries, by the URDF, and where its centre is.

        Args:
            q: Joint values, (n, j) [rad] or [m]; unlisted joints are at neutral.

        Returns:
            Masses (j,) [kg] and centres in the base frame (n, j, 3) [m]; where there is no mass, the joint's origin.
        """
        return self.by_pinocchio.carried(q)

    @cached_property
    def _tree(self) -> Tree:
        return urdf.parse(self.urdf)

    @cached_property
    def by_pinocchio(self) -> PinocchioModel:
        """The arm's Pinocchio model, from the checked URDF; joints that are not listed are fixed at neutral."""
        tree, moving = self._tree, {name: f"joint_{i}" for i, name in enumerate(self.joints)}
        return PinocchioModel(urdf.minimal(tree, moving), f"link_{list(tree.links).index(self.flange)}", self.gravity)

    @cached_property
    def placements(self) -> Array:
        """Each joint on the listed joint, or base, before it, (j, 4, 4); unlisted ones are at neutral."""
        return self.by_pinocchio.placements

    @cached_property
    def axes(self) -> Array:
        """Unit axis in the joint's frame, (j, 3)."""
        return self.by_pinocchio.axes

    @property
    def end(self) -> Array:
        """From the last joint of the chain to the flange, (4, 4)."""
        return self.by_pinocchio.end

    def __getstate__(self) -> dict[str, Any]:
        """All but Pinocchio's model, which another process builds for itself."""
        return {name: value for name, value in self.__dict__.items() if name != "by_pinocchio"}

    @cached_property
    def has_masses(self) -> bool:
        """Whether any link that a listed joint moves has a mass."""
        return bool((self.by_pinocchio.masses > 0.0).any())

    def with_placements(self, placements: Array) -> Self:
        """The same arm with its joints placed anew, (j, 4, 4), as `placements` means them."""
        text = self.urdf_with(placements)
        return type(self).from_urdf(text, flange=self.flange, joints=self.joints, gravity=self.gravity)

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


def _listed(tree: Tree, path: list[Joint], names: Sequence[str] | None) -> list[Joint]:
    if names is None:
        return [joint for joint in path if joint.moves and joint.follows is None]
    for i, name in enumerate(names):
        if name not in tree.joints or not tree.joints[name].moves:
            raise unknown_joint(tree.source, name, [j.name for j in tree.joints.values() if j.moves])
        if name in names[:i]:
            raise RobotError(f"Joint '{name}' of {tree.source} is listed twice. List each joint once.")
    return [tree.joints[name] for name in names]
