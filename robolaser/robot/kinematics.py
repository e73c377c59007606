"""A robot's arm: joint values to flange poses, many candidates at once, and gravity torques."""

from collections.abc import Sequence
from dataclasses import dataclass, field
from functools import cached_property, partial
from typing import Any, Self, final

import numpy as np

from robolaser.arrays import Array, Bools, Ints
from robolaser.duals import bare, is_dual
from robolaser.errors import UsageError
from robolaser.geometry.rigid_motion import exp_so3, inverse, log_so3, pose
from robolaser.robot import damped_newton
from robolaser.robot.flange_motion import FlangeMotion
from robolaser.robot.pinocchio_model import PinocchioModel
from robolaser.robot.reading import read_arm
from robolaser.robot.urdf.editing import with_placements

DOWN = (0.0, 0.0, -9.81)  # gravity in the frame of an upright base [m/s²]
NEAR_AXIS = np.cos(np.radians(2.0))  # bases are mounted along axes
REACHED = 1e-9  # [m, rad]
STARTS = 40  # of an inverse, besides the given one: fewer miss some poses within reach of a six-axis arm


@final
@dataclass(frozen=True, eq=False, repr=False)
class Robot:
    """A robot as its URDF describes it; the base frame is the URDF's root link.

    Joint limits are carried, not enforced: `forward` computes outside them too; the data set checks.
    """

    name: str
    joints: tuple[str, ...]  # the moving joints that are read, in the order of the columns of q
    flange: str  # the link that carries the sensor
    gravity: tuple[float, float, float]  # in the base frame [m/s²]
    urdf: str  # the URDF as it was read
    # derived from the URDF; joints that are not listed and follow none of these are fixed at neutral
    by_pinocchio: PinocchioModel = field(compare=False)
    chain: tuple[int, ...] = field(compare=False)  # indices into `joints` of those that move the flange, base first
    lower: Array = field(compare=False)  # least value of each joint, (j,) [rad] or [m]; -inf for continuous joints
    upper: Array = field(compare=False)  # largest value, likewise; inf for continuous joints
    prismatic: Bools = field(compare=False)  # whether each joint slides, (j,)
    placements: Array = field(compare=False)  # each joint on the moving joint, or base, that carries it, (j, 4, 4)
    axes: Array = field(compare=False)  # unit axis in the joint's frame, (j, 3)
    end: Array = field(compare=False)  # from the last joint that carries the flange to it, (4, 4)
    has_masses: bool = field(compare=False)  # whether any link that a listed joint moves has a mass

    @classmethod
    def from_urdf(
        cls,
        text: str,
        *,
        flange: str,
        joints: Sequence[str] | None = None,
        gravity: Sequence[float] | Array = DOWN,
        source: str = "robot.urdf",
    ) -> Self:
        """Read a robot; joints that are not listed stay at neutral, or follow those that they mimic.

        Args:
            text: The URDF itself; meshes are never needed.
            flange: The link that carries the sensor.
            joints: The columns of q; when absent, all that move the flange and mimic none, from base to flange.
            gravity: In the base frame, (3,) [m/s²].
            source: Name of the URDF in error messages.

        Raises:
            RobotError: The text is no robot; there is no such flange or no such moving joint; a joint is listed twice;
                or none of the joints moves the flange.
            UsageError: The gravity is not three numbers.
        """
        try:
            x, y, z = map(float, np.asarray_chkfinite(gravity, dtype=float))
        except (TypeError, ValueError):
            raise UsageError(f"gravity is {gravity!r}, expected three numbers [m/s²].") from None
        arm, name = read_arm(text, flange=flange, joints=joints, source=source)
        arm.model.gravity.linear = np.array([x, y, z])
        lower, upper = (limit[arm.columns] for limit in arm.limits)
        return cls(
            name=name,
            joints=tuple(arm.moving[column] for column in arm.columns),
            flange=flange,
            gravity=(x, y, z),
            urdf=text,
            by_pinocchio=arm,
            chain=arm.chain,
            lower=lower,
            upper=upper,
            prismatic=arm.slides[arm.columns],
            placements=arm.placements[arm.columns],
            axes=arm.axes[arm.columns],
            end=arm.end,
            has_masses=bool((arm.masses > 0.0).any()),
        )

    def __reduce__(self) -> tuple[Any, ...]:
        """Another process builds its own Pinocchio model."""
        read = partial(type(self).from_urdf, flange=self.flange, joints=self.joints, gravity=self.gravity)
        return read, (self.urdf,)

    def other_gravity(self, direction: Array) -> Array | None:
        """The gravity in the base frame of a direction (3,), along an axis if it is near one, (3,).

        None if it is nearly the arm's own.
        """
        stated = np.array(self.gravity)
        size, along = float(np.linalg.norm(stated)), direction / np.linalg.norm(direction)
        axis = int(np.argmax(np.abs(along)))
        along = np.sign(along[axis]) * np.eye(3)[axis] if abs(along[axis]) > NEAR_AXIS else along
        return None if along @ stated > NEAR_AXIS * size else size * along

    def under(self, gravity: Sequence[float] | Array) -> Self:
        """The same arm under another gravity in the base frame, (3,) [m/s²]."""
        return type(self).from_urdf(self.urdf, flange=self.flange, joints=self.joints, gravity=gravity)

    def forward(self, q: Array, placements: Array | None = None) -> Array:
        """Pose of the flange. Joint limits are not checked here.

        Args:
            q: Joint values, (c or 1, n, j) [rad] or [m]; fewer leading axes, (n, j) or (j,), give fewer.
            placements: Of the joints, in place of the nominal ones, (c or 1, n or 1, j, 4, 4).

        Returns:
            T_base_flange, (c, n, 4, 4); with derivatives where values or placements carry some.

        Raises:
            UsageError: There is not a value for each joint.
        """
        if not is_dual(q) and np.ndim(q) < 3:
            whole: Array = self.forward(self._rows(q), placements)[0]
            return whole if np.ndim(q) == 2 else whole[0]
        if is_dual(q) or is_dual(placements):
            nominal = self.placements[None, None] if placements is None else placements
            return self.motion(bare(q), bare(nominal), by_placements=is_dual(nominal)).carried(q, nominal)
        return self.by_pinocchio.flange(q, placements)

    def joint_frames(self, q: Array, placements: Array | None = None) -> Array:
        """T_base_joint of the chain, from base to flange, each turned by its own value, (c, n, len(chain), 4, 4).

        Arguments as for `forward`; fewer leading axes give fewer.
        """
        if np.ndim(q) < 3:
            whole: Array = self.joint_frames(self._rows(q), placements)[0]
            return whole if np.ndim(q) == 2 else whole[0]
        return self.by_pinocchio.frames(q, placements)[:, :, [self.by_pinocchio.columns[i] for i in self.chain]]

    def motion(self, q: Array, placements: Array | None = None, *, by_placements: bool = True) -> FlangeMotion:
        """Pose of the flange, as `forward`, and its twists by the joints and, if wanted, their placements."""
        return FlangeMotion(*self.by_pinocchio.flange_and_twists(q, placements, by_placements=by_placements))

    def jacobian(self, q: Array, points: Array | None = None) -> Array:
        """The geometric Jacobian of a point that the flange carries, in the base frame.

        Args:
            q: Joint values, (c, n, j) [rad] or [m]; fewer leading axes, (n, j) or (j,), give fewer.
            points: In the base frame, (c or 1, n, 3) [m]; absent, the flange's origin.

        Returns:
            Velocity of the point, then angular velocity, per unit speed of each joint, (c, n, 6, j); zero for joints
            that do not move the flange.

        Raises:
            UsageError: There is not a value for each joint.
        """
        if np.ndim(q) < 3:
            whole: Array = self.jacobian(self._rows(q), points)[0]
            return whole if np.ndim(q) == 2 else whole[0]
        return self.motion(q, by_placements=False).jacobian(points)

    def _rows(self, q: Array) -> Array:
        """Joint values of poses, (n, j) or (j,), as (1, n, j)."""
        rows = np.atleast_2d(np.asarray(q, dtype=np.float64))
        if rows.shape[1] != len(self.joints):
            raise UsageError(
                f"{rows.shape[1]} joint values for each pose, but {self.name} has {len(self.joints)} joints:"
                f" {', '.join(self.joints)}."
            )
        return rows[None]

    def inverse(self, T_base_flange: Array, start: Array | None = None) -> tuple[Array, Bools]:
        """Joint values within the limits that bring the flange to given poses.

        Of several solutions, the one that damped Newton steps reach first from the start; if they reach none, from
        other starts in the joints' range, the same in each call.

        Args:
            T_base_flange: Poses, (n, 4, 4); without that leading axis, as one pose, neither has the rest.
            start: Joint values where the search starts, (n, j) [rad] or [m]; absent, the middle of the joints' range.

        Returns:
            Joint values (n, j) [rad] or [m], the last ones tried where the pose was not reached, and whether each pose
            was reached, (n,): to 1e-9 m and rad. One that was not may, rarely, be reached from another start; arms of
            fewer than six joints reach few poses.
        """
        if np.ndim(T_base_flange) == 2:
            q, reached = self.inverse(T_base_flange[None], None if start is None else start[None])
            return q[0], reached[0]

        def toward(goal: Array, start: Array) -> tuple[Array, Bools]:
            def missing(q: Array, which: Ints) -> tuple[Array, Array]:
                motion, wanted = self.motion(q[None], by_placements=False), goal[which]
                T = motion.T_base_flange[0]
                turn = log_so3(wanted[:, :3, :3] @ np.swapaxes(T[:, :3, :3], -1, -2))
                return np.concatenate([wanted[:, :3, 3] - T[:, :3, 3], turn], axis=-1), motion.jacobian()[0]

            return damped_newton.solve(missing, start, self.range, REACHED)

        rng, (lower, upper) = np.random.default_rng(0), self.range
        middle = np.broadcast_to((lower + upper) / 2, (len(T_base_flange), len(self.joints)))
        q, reached = toward(T_base_flange, middle if start is None else start)
        for _ in range(STARTS):
            missed = np.flatnonzero(~reached)
            if not len(missed):
                break
            other = rng.uniform(lower, upper, (len(missed), q.shape[1]))
            q[missed], reached[missed] = toward(T_base_flange[missed], other)
        return q, reached

    @property
    def range(self) -> tuple[Array, Array]:
        """Least and largest used value of each joint, (j,) and (j,) [rad] or [m]: its limits, at most a turn."""
        lower = np.where(self.prismatic, self.lower, np.maximum(self.lower, np.minimum(-np.pi, self.upper - np.pi)))
        upper = np.where(self.prismatic, self.upper, np.minimum(self.upper, np.maximum(np.pi, lower + np.pi)))
        return lower, upper

    def gravity_torques(self, q: Array) -> Array:
        """Torque of each joint that holds the arm still at q, with all masses, (..., j) -> (..., j) [Nm] or [N].

        Unlisted joints are at neutral; zeros for a URDF without masses.
        """
        return self.by_pinocchio.gravity_torques(q.reshape(-1, q.shape[-1])).reshape(q.shape)

    def carried(self, q: Array) -> tuple[Array, Array]:
        """The mass that each joint carries, by the URDF, (j,) [kg], and its centre at q (n, j), (n, j, 3) [m].

        Centres are in the base frame; where there is no mass, the joint's origin. Unlisted joints are at neutral.
        """
        return self.by_pinocchio.carried(q)

    @property
    def base(self) -> str:
        """Name of the root link."""
        return self.by_pinocchio.links[0].name

    @cached_property
    def links(self) -> tuple[str, ...]:
        """Names of the links, each after the one that carries it."""
        return tuple(link.name for link in self.by_pinocchio.links)

    def with_placements(self, placements: Array, offsets: Array | None = None) -> Self:
        """The same arm with other placements of its joints, (j, 4, 4), and zeros moved by offsets, (j,) [rad or m].

        Joints that mimic one follow its true value, so that their zeros move, too.
        """
        arm, placed = self.by_pinocchio, self.by_pinocchio.placements.copy()
        placed[arm.columns] = placements
        if offsets is not None:
            along = arm.axes * (arm.ratios @ offsets)[:, None]
            turn, shift = (np.where(arm.slides[:, None] == slides, along, 0.0) for slides in (False, True))
            placed = placed @ pose(exp_so3(turn), shift)
        moved = {
            arm.moving[link.joint]: link.T_parent_link @ inverse(arm.placements[link.joint]) @ placed[link.joint]
            for link in arm.links
            if link.joint is not None and not np.array_equal(placed[link.joint], arm.placements[link.joint])
        }
        text = with_placements(self.urdf, moved)
        return type(self).from_urdf(text, flange=self.flange, joints=self.joints, gravity=self.gravity)
