"""The arm of `corrected.py`: the sources of this module and of the effects are copied there, with an arm's numbers."""

from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property
from typing import Any, final

import numpy as np

from robolaser.arrays import Array
from robolaser.geometry.rigid_motion import exp_so3, pose
from robolaser.model.effects.gravity_load import carried_masses, gravity_torques, link_load, torques_of_one_kg

JOINTS: tuple[str, ...] = ()  # from here on, an arm's own numbers stand in their place
PLACEMENTS: Array = np.zeros((0, 4, 4))
AXES: Array = np.zeros((0, 3))
SLIDES: Array = np.zeros(0, dtype=bool)
CHAIN: tuple[int, ...] = ()
END: Array = np.eye(4)
MASSES: Array = np.zeros((0, 4))
GRAVITY: tuple[float, ...] = ()
PAYLOAD_KG = 0.0
DURATION = 0.0
COLDEST_C: float | None = None
WARMING_C = 0.0
CALIBRATED: Array = np.zeros((0, 0))
FRAMES: dict[str, Array] = {}
CELL: dict[str, Array] = {}
EFFECTS: list[tuple[Any, str, tuple[str, ...]]] = []

STEP, ENOUGH, ROUNDS = 1e-6, 1e-12, 100


@final
class NominalArm:
    """The arm without its effects."""

    joints, placements, axes, prismatic, chain, end, gravity = JOINTS, PLACEMENTS, AXES, SLIDES, CHAIN, END, GRAVITY

    def joint_frames(self, q: Array, placements: Array | None = None) -> Array:
        """T_base_joint along the chain, each joint moved by its value, (c or 1, n, j) -> (c, n, chain, 4, 4)."""
        placed = self.placements[None, None] if placements is None else placements
        T, frames = np.eye(4), []
        for i in self.chain:
            value = q[..., i, None] * self.axes[i]
            motion = pose(np.eye(3), value) if self.prismatic[i] else pose(exp_so3(value), np.zeros(3))
            T = T @ placed[:, :, i] @ motion
            frames.append(T)
        return np.stack(frames, axis=2)

    def forward(self, q: Array, placements: Array | None = None) -> Array:
        """T_base_flange, (c or 1, n, j) -> (c, n, 4, 4)."""
        return np.asarray(self.joint_frames(q, placements)[:, :, -1] @ self.end)

    def jacobian(self, q: Array) -> Array:
        """Velocity of the flange's origin per unit speed of each joint, (c, n, j) -> (c, n, 3, j)."""
        frames, chain = self.joint_frames(q), list(self.chain)
        axes = np.einsum("cnkab,kb->cnka", frames[..., :3, :3], self.axes[chain])
        flange = (frames[:, :, -1] @ self.end)[:, :, None, :3, 3]
        turns = np.cross(axes, flange - frames[..., :3, 3])
        moves = np.zeros((*q.shape[:2], 3, q.shape[2]))
        moves[..., chain] = np.swapaxes(np.where(self.prismatic[chain][:, None], axes, turns), 2, 3)
        return moves

    def carried(self, q: Array) -> tuple[Array, Array]:
        """The mass that each joint carries, (j,) [kg], and where its centre is, (n, j) -> (n, j, 3) [m]."""
        frames = self.joint_frames(q[None])[0]
        centres = frames[..., :3, 3] + np.einsum("nkab,kb->nka", frames[..., :3, :3], MASSES[:, 1:])
        moments = np.cumsum((MASSES[:, :1] * centres)[:, ::-1], axis=1)[:, ::-1]
        beyond = np.cumsum(MASSES[::-1, 0])[::-1]
        mass, centre = np.zeros(q.shape[1]), np.zeros((*q.shape, 3))
        mass[list(self.chain)] = beyond
        centre[:, list(self.chain)] = moments / np.where(beyond > 0, beyond, 1.0)[:, None]
        return mass, centre

    def gravity_torques(self, q: Array) -> Array:
        """What each joint must bear to hold the arm still, (n, j) -> (n, j) [Nm or N]."""
        frames, (mass, centre) = self.joint_frames(q[None])[0], self.carried(q)
        chain, torques = list(self.chain), np.zeros_like(q)
        axes = np.einsum("nkab,kb->nka", frames[..., :3, :3], self.axes[chain])
        levers = np.cross(axes, centre[:, chain] - frames[..., :3, 3])
        torques[:, chain] = -mass[chain] * (np.where(self.prismatic[chain][:, None], axes, levers) @ self.gravity)
        return torques


@final
@dataclass(frozen=True, eq=False)
class Conditions:
    """Poses as effects see them: what `robolaser.model.effects.run.Run` is to them in a calibration."""

    q: Array  # joint values as read, (n, j)
    steps: int = 1  # poses of each path; those of the first poses stand first
    time_s: Any = None
    temperature_c: Any = None
    qd: Any = None  # joint velocities, (n, j)
    robot = NominalArm()

    @property
    def paths(self) -> tuple[Array, ...]:
        """Numbers of the poses as they followed one another, of each path."""
        return tuple(np.arange(len(self.q)).reshape(self.steps, -1).T)

    @property
    def progress(self) -> Array:
        """Share of the calibrated run's length that has passed, (n,)."""
        return np.broadcast_to(np.asarray(self.time_s, dtype=float) / DURATION, len(self.q))

    @property
    def rise(self) -> Array | None:
        """Temperature above the lowest of the calibrated run over its largest rise, (n,)."""
        if COLDEST_C is None:
            return None
        return np.broadcast_to((np.asarray(self.temperature_c, dtype=float) - COLDEST_C) / WARMING_C, len(self.q))

    @property
    def reference(self) -> "Conditions":
        """The calibrated poses, to which some effects are relative."""
        return Conditions(CALIBRATED)

    @cached_property
    def payload_kg(self) -> Array:
        """At the flange, (n,)."""
        return np.full(len(self.q), PAYLOAD_KG)

    @cached_property
    def gravity_torques(self) -> Array:
        """What each joint must bear, (n, j) [Nm or N]."""
        return gravity_torques(self.robot, self.q, self.payload_kg)  # type: ignore[arg-type]

    @cached_property
    def torques_of_one_kg(self) -> Array:
        """What each joint must bear of one kilogram at the flange, (n, j) [Nm or N]."""
        return torques_of_one_kg(self.robot, self.q)  # type: ignore[arg-type]

    @cached_property
    def carried(self) -> tuple[Array, Array]:
        """The mass that each joint carries and its first moment about the base's origin."""
        return carried_masses(self.robot, self.q, self.payload_kg)  # type: ignore[arg-type]

    @cached_property
    def flange(self) -> Array:
        """T_base_flange by the nominal arm, (n, 4, 4)."""
        return np.asarray(self.robot.forward(self.q[None])[0])

    def link_load(self, joint: str) -> Any:
        """What hangs on the link before a joint that is not the first."""
        at, frames = self.robot.chain.index(self.robot.joints.index(joint)), self.robot.joint_frames(self.q[None])[0]
        return link_load(self.robot, frames, self.flange[:, :3, 3], self.carried, at)  # type: ignore[arg-type]

    @cached_property
    def overturning_moment(self) -> Array:
        """The moment of the weight of all that moves about the base's origin, (n, 3) [Nm]."""
        return np.asarray(np.cross(self.carried[1][:, self.robot.chain[0]], np.array(self.robot.gravity)))


def forward(q: Any, before: Any = None, time_s: Any = None, temperature_c: Any = None, velocity: Any = None) -> Array:
    """Where the flange is. An effect that needs what is not given is left out, see LEAVES_OUT.

    Args:
        q: Joint values, (n, j) or (j,) [rad or m], in the order of JOINTS.
        before: Those of the pose before each, alike, or of several poses before, (k, n, j), the oldest first.
        time_s: Since the run began, one or (n,) [s]; where the data had no times, how many poses it is after the first.
        temperature_c: Of the arm, one or (n,) [°C].
        velocity: Of the joints, like q; an effect of the timing of measurements needs it.

    Returns:
        T_base_flange, (n, 4, 4) or (4, 4).
    """
    read = np.asarray(q, dtype=float)
    poses = read.reshape(-1, read.shape[-1])
    path = np.zeros((0, *poses.shape)) if before is None else np.asarray(before, float).reshape(-1, *poses.shape)
    path = np.concatenate([path, poses[None]])

    def along(values: Any) -> Any:
        one = None if values is None else np.asarray(values, dtype=float)
        return one if one is None or one.ndim == 0 else np.concatenate([one.reshape(len(poses), -1)] * len(path))

    at = {"time_s": along(time_s), "temperature_c": along(temperature_c), "qd": along(velocity)}
    at = {name: value[:, 0] if name != "qd" and np.ndim(value) else value for name, value in at.items()}
    run = Conditions(path.reshape(-1, poses.shape[1]), len(path), **at)
    given = {"before": before, "time_s": time_s, "temperature_c": temperature_c, "velocity": velocity}
    lacking = {name for name, value in given.items() if value is None}

    def passed(stage: str, value: Array) -> Array:
        for effect, acts_at, needs in EFFECTS:
            if acts_at == stage and not lacking & set(needs):
                value = effect.apply(value, run)
        return value

    angles, placements = passed("JOINTS", run.q[None]), passed("LINKS", PLACEMENTS[None, None])
    T = passed("FLANGE", run.robot.forward(angles, placements))
    return np.asarray(T[0, -len(poses) :].reshape(*read.shape[:-1], 4, 4))


def nominal(q: Any) -> Array:
    """T_base_flange by the nominal arm, as a controller that knows no effects computes it; shapes as in `forward`."""
    read = np.asarray(q, dtype=float)
    return np.asarray(NominalArm().forward(read.reshape(1, -1, read.shape[-1]))[0].reshape(*read.shape[:-1], 4, 4))


def joints_for(T_base_flange: Any, start: Any = None, **conditions: Any) -> Array:
    """Joint values at which the corrected arm's flange is at poses, or nearest to them where it cannot be there.

    Damped least squares over metres and radians alike (Levenberg 1944).

    Args:
        T_base_flange: (n, 4, 4) or (4, 4).
        start: Joint values near by, (n, j) or (j,); zeros where they are not given.
        conditions: As `forward` takes them.

    Returns:
        (n, j) or (j,).
    """
    wanted = np.asarray(T_base_flange, dtype=float)
    goals = wanted.reshape(-1, 4, 4)
    q = np.broadcast_to(np.zeros(len(JOINTS)) if start is None else start, (len(goals), len(JOINTS))).astype(float)

    def away(values: Array) -> Array:
        T = forward(values, **conditions)
        R = goals[:, :3, :3] @ np.swapaxes(T[:, :3, :3], 1, 2)
        turn = np.stack([R[:, 2, 1] - R[:, 1, 2], R[:, 0, 2] - R[:, 2, 0], R[:, 1, 0] - R[:, 0, 1]], axis=1) / 2
        opposite = np.trace(R, axis1=1, axis2=2)[:, None] < 1.0
        length = np.linalg.norm(turn, axis=1, keepdims=True)
        turn = np.where(opposite, turn * (2.0 - length) / np.maximum(length, STEP), turn)
        return np.concatenate([goals[:, :3, 3] - T[:, :3, 3], turn], axis=1)

    damping, error = np.full(len(goals), 1e-3), away(q)
    for _ in range(ROUNDS):
        moves = STEP * np.eye(len(JOINTS))
        J = np.stack([(away(q - move) - away(q + move)) / (2 * STEP) for move in moves], axis=2)
        normal = np.swapaxes(J, 1, 2) @ J + damping[:, None, None] * np.eye(len(JOINTS))
        step = np.linalg.solve(normal, np.swapaxes(J, 1, 2) @ error[..., None])[..., 0]
        tried = away(q + step)
        better = np.sum(tried**2, axis=1) < np.sum(error**2, axis=1)
        q, error = np.where(better[:, None], q + step, q), np.where(better[:, None], tried, error)
        damping = np.clip(np.where(better, damping / 10, damping * 10), 1e-12, 1e6)
        if np.abs(step).max(initial=0.0) < ENOUGH:
            break
    return q.reshape(*wanted.shape[:-2], len(JOINTS))


def corrected_targets(q: Any, **conditions: Any) -> Array:
    """What to command so that the arm gets to where a controller that knows only the nominal arm expects it at q."""
    return joints_for(nominal(q), start=q, **conditions)


def sensor(q: Sequence[float], **conditions: Any) -> dict[str, Array]:
    """Where the sensor's frames are in the base frame, by name; see `forward`."""
    T = forward(q, **conditions)
    return {name: T @ T_flange_frame for name, T_flange_frame in FRAMES.items()} | CELL
