"""The arm of `corrected.py`: the sources of this module and of the effects are copied there, with an arm's numbers."""

from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property
from typing import Any, final

import numpy as np

from robolaser.arrays import Array
from robolaser.geometry.rigid_motion import exp_so3, pose
from robolaser.model.effects.gravity_load import Loads

JOINTS: tuple[str, ...] = ()  # from here on replaced by an arm's numbers
CHAIN: tuple[int, ...] = ()
COLUMNS: list[int] = []
RATIOS: Array = np.zeros((0, 0))
OFFSETS: Array = np.zeros(0)
PARENTS: list[int] = []
PLACEMENTS: Array = np.zeros((0, 4, 4))
AXES: Array = np.zeros((0, 3))
SLIDES: Array = np.zeros(0, dtype=bool)
RANGE: Array = np.zeros((2, 0))
MASSES: Array = np.zeros((0, 4))
TIP = 0
END: Array = np.eye(4)
GRAVITY: tuple[float, ...] = ()
PAYLOAD_KG = 0.0
DURATION = 0.0
COLDEST_C: float | None = None
WARMING_C = 0.0
CALIBRATED: Array = np.zeros((0, 0))
FRAMES: dict[str, Array] = {}
CELL: dict[str, Array] = {}
EFFECTS: list[tuple[Any, str, tuple[str, ...]]] = []

STEP, ENOUGH, ROUNDS, STARTS = 1e-6, 1e-12, 100, 20
REACHED = 1e-12  # squared distance [m² + rad²] up to which a pose is reached


@final
class NominalArm:
    """The arm without its effects: m moving joints, some of which follow the j that are read."""

    joints, chain, gravity = JOINTS, CHAIN, GRAVITY
    placements, axes, prismatic = PLACEMENTS[COLUMNS], AXES[COLUMNS], SLIDES[COLUMNS]

    def frames(self, q: Array, placements: Array | None = None) -> Array:
        """T_base_joint of all joints, each moved by its value, (c or 1, n, j) -> (c, n, m, 4, 4)."""
        placed = [placement[None, None] for placement in PLACEMENTS]
        if placements is not None:
            for i, number in enumerate(COLUMNS):
                placed[number] = placements[:, :, i]
        values = q @ RATIOS.T + OFFSETS
        frames: list[Array] = []
        for number, parent in enumerate(PARENTS):
            value = values[..., number, None] * AXES[number]
            motion = pose(np.eye(3), value) if SLIDES[number] else pose(exp_so3(value), np.zeros(3))
            frames.append((frames[parent] if parent >= 0 else np.eye(4)) @ placed[number] @ motion)
        return np.stack(np.broadcast_arrays(*frames), axis=2)

    def joint_frames(self, q: Array, placements: Array | None = None) -> Array:
        """T_base_joint along the chain, (c or 1, n, j) -> (c, n, chain, 4, 4)."""
        return self.frames(q, placements)[:, :, [COLUMNS[i] for i in CHAIN]]

    def forward(self, q: Array, placements: Array | None = None) -> Array:
        """T_base_flange, (c or 1, n, j) -> (c, n, 4, 4)."""
        return np.asarray(self.frames(q, placements)[:, :, TIP] @ END)

    def jacobian(self, q: Array) -> Array:
        """Velocity of the flange's origin per unit speed of each joint, (c, n, j) -> (c, n, 3, j)."""
        frames = self.frames(q)
        axes = np.einsum("cnkab,kb->cnka", frames[..., :3, :3], AXES)
        flange = (frames[:, :, TIP] @ END)[:, :, None, :3, 3]
        moves = np.where(SLIDES[:, None], axes, np.cross(axes, flange - frames[..., :3, 3]))
        way = [TIP]
        while PARENTS[way[-1]] >= 0:
            way.append(PARENTS[way[-1]])
        return np.asarray(np.swapaxes(moves[:, :, way], 2, 3) @ RATIOS[way])

    def beyond(self, q: Array) -> tuple[Array, Array, Array]:
        """Frames of all joints, (n, m, 4, 4), the mass that each carries, (m,) [kg], its first moment, (n, m, 3)."""
        frames, mass = self.frames(q[None])[0], MASSES[:, 0].copy()
        centres = frames[..., :3, 3] + np.einsum("nkab,kb->nka", frames[..., :3, :3], MASSES[:, 1:])
        moments = mass[:, None] * centres
        for number in range(len(PARENTS) - 1, 0, -1):
            if PARENTS[number] >= 0:
                mass[PARENTS[number]] += mass[number]
                moments[:, PARENTS[number]] += moments[:, number]
        return frames, mass, moments

    def carried(self, q: Array) -> tuple[Array, Array]:
        """The mass that each joint carries, (j,) [kg], and its centre, (n, j) -> (n, j, 3) [m]."""
        _, mass, moments = self.beyond(q)
        centres = moments / np.where(mass > 0, mass, 1.0)[:, None]
        return mass[COLUMNS], centres[:, COLUMNS]

    def gravity_torques(self, q: Array) -> Array:
        """Torque of each joint that holds the arm still, (n, j) -> (n, j) [Nm or N]."""
        frames, mass, moments = self.beyond(q)
        axes = np.einsum("nkab,kb->nka", frames[..., :3, :3], AXES)
        levers = np.cross(axes, moments - mass[:, None] * frames[..., :3, 3])
        return np.asarray(-np.where(SLIDES[:, None], mass[:, None] * axes, levers) @ self.gravity @ RATIOS)


@final
@dataclass(frozen=True, eq=False)
class Conditions:
    """Poses as effects see them: the counterpart of `robolaser.model.effects.run.Run` in a calibration."""

    q: Array  # joint values as read, (n, j)
    steps: int = 1  # poses of each path, the first poses first
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
    def progress_of_all(self) -> Array:
        """The same, (n,): there was one run."""
        return self.progress

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
    def loads(self) -> Loads:
        """Loads of the arm, including the payload at the flange."""
        return Loads(self.robot, self.q, np.full(len(self.q), PAYLOAD_KG))  # type: ignore[arg-type]

    @cached_property
    def flange(self) -> Array:
        """T_base_flange by the nominal arm, (n, 4, 4)."""
        return np.asarray(self.robot.forward(self.q[None])[0])

    @property
    def gravity_in_flange(self) -> Array:
        """The direction of gravity in the flange frame, unit vectors (n, 3)."""
        down = np.array(self.robot.gravity)
        return np.asarray((down / np.linalg.norm(down)) @ self.flange[:, :3, :3])


def forward(q: Any, before: Any = None, time_s: Any = None, temperature_c: Any = None, velocity: Any = None) -> Array:
    """Pose of the flange. An effect with missing input is omitted, see LEAVES_OUT.

    Args:
        q: Joint values, (n, j) or (j,) [rad or m], in the order of JOINTS.
        before: Joint values of the pose before each, shaped like q, or of several poses, (k, n, j), the oldest first.
        time_s: Since the run began, one or (n,) [s]; if the data had no times, the number of poses since the first.
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

    angles, placements = passed("JOINTS", run.q[None]), passed("LINKS", run.robot.placements[None, None])
    T = passed("FLANGE", run.robot.forward(angles, placements))
    return np.asarray(T[0, -len(poses) :].reshape(*read.shape[:-1], 4, 4))


def nominal(q: Any) -> Array:
    """T_base_flange by the nominal arm, as a controller that knows no effects computes it; shapes as in `forward`."""
    read = np.asarray(q, dtype=float)
    return np.asarray(NominalArm().forward(read.reshape(1, -1, read.shape[-1]))[0].reshape(*read.shape[:-1], 4, 4))


def joints_for(T_base_flange: Any, start: Any = None, **conditions: Any) -> Array:
    """Joint values at which the corrected arm's flange is at poses, or nearest to unreachable ones.

    Damped least squares with equal weights of metres and radians (Levenberg 1944).

    Args:
        T_base_flange: (n, 4, 4) or (4, 4).
        start: Joint values near by, (n, j) or (j,). Default: zeros, and for poses not reached from there others within
            the joints' limits, the same in each call. The result may be beyond these.
        conditions: As in `forward`.

    Returns:
        (n, j) or (j,).
    """
    wanted = np.asarray(T_base_flange, dtype=float)
    goals, rng, (lower, upper) = wanted.reshape(-1, 4, 4), np.random.default_rng(0), RANGE
    q = np.broadcast_to(np.zeros(len(JOINTS)) if start is None else start, (len(goals), len(JOINTS))).astype(float)
    q, left = descended(goals, q, conditions)
    for _ in range(STARTS if start is None else 0):
        missed = np.flatnonzero(left >= REACHED)
        if not len(missed):
            break
        given = {name: of_some(name, value, missed, len(goals)) for name, value in conditions.items()}
        other, far = descended(goals[missed], rng.uniform(lower, upper, (len(missed), len(JOINTS))), given)
        nearer = far < left[missed]
        q[missed[nearer]], left[missed[nearer]] = other[nearer], far[nearer]
    return q.reshape(*wanted.shape[:-2], len(JOINTS))


def of_some(name: str, value: Any, some: Any, count: int) -> Any:
    """An argument of `forward` for some of so many poses; a single number is for all."""
    if np.ndim(value) == 0:
        return value
    if name == "before":
        return np.reshape(value, (-1, count, len(JOINTS)))[:, some]
    return np.reshape(value, (count, -1))[some]


def descended(goals: Array, q: Array, conditions: dict[str, Any]) -> tuple[Array, Array]:
    """Joint values after a descent, (n, j), and the flange's squared distances from poses, (n,)."""

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
    return q, np.sum(error**2, axis=1)


def corrected_targets(q: Any, **conditions: Any) -> Array:
    """Joint commands for the flange pose that a controller with the nominal arm expects at q."""
    return joints_for(nominal(q), start=q, **conditions)


def sensor(q: Sequence[float], **conditions: Any) -> dict[str, Array]:
    """The sensor's frames in the base frame, by name; see `forward`."""
    T = forward(q, **conditions)
    return {name: T @ T_flange_frame for name, T_flange_frame in FRAMES.items()} | CELL
