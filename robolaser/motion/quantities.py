"""Quantities for the columns of linear rows: speeds, directions, torques of the rigid arm."""

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from functools import cached_property
from typing import final

import numpy as np

from robolaser.arrays import Array, Bools, Ints
from robolaser.model.effects.backlash import play
from robolaser.motion.gap import medians, root_mean_squares
from robolaser.motion.log import MotionLog
from robolaser.robot.kinematics import Robot

SMOOTHED_S = 0.12  # width of the parabolas for velocities and accelerations
EDGE_S = 0.4  # at the ends of a run, where a recorder's own filter has edges
STANDS_RAD_S = 0.01  # below about this speed the direction of motion is not known
SPANS_RAD = 0.02  # range of a joint's readings that is motion rather than noise
LEAST_NM = 1e-6  # smaller torques are none
TURNS_RAD = 1e-3  # reversal, more than noise, after which a joint's gear bears on the other side
MOST_ROWS = 6_000
INERTIA_ROWS = 50
JERKS = 9.0  # times the median size: six standard deviations
MISSES = 1.5  # multiple of the usual step at which rows are missing


@final
@dataclass(frozen=True, eq=False)
class Quantities:
    """Quantities at the used rows, (n, j) each."""

    log: MotionLog
    rows: Ints  # of the log, (n,)
    turning: tuple[Array, Array]  # speeds and accelerations of all rows of the log
    rigid: Array  # torques of the URDF's rigid arm with the stated payload at the flange's origin [Nm]
    measured: Array  # values of the rows, NaN where nothing was recorded
    torque_noise: Array  # of `rigid`, from the readings that accelerations are computed from, (j,) [Nm]
    kind: str = "torque"  # of the rows

    @cached_property
    def run(self) -> Ints:
        """The run of each row, (n,)."""
        return self.log.run[self.rows]

    @cached_property
    def time_s(self) -> Array:
        """Times, (n,) [s]."""
        return self.log.time_s[self.rows]

    @cached_property
    def q(self) -> Array:
        """Readings [rad]."""
        return self.log.q[self.rows]

    @cached_property
    def speed(self) -> Array:
        """Speeds [rad/s]."""
        return self.turning[0][self.rows]

    @cached_property
    def acceleration(self) -> Array:
        """Accelerations [rad/s²]."""
        return self.turning[1][self.rows]

    @property
    def lacking(self) -> str:
        """Reason why there are no rows; "" where there are some."""
        if len(self.q):
            return ""
        unread = [name for name, read in zip(self.log.joints, self.log.has("q"), strict=True) if not read]
        if unread:
            return f"there are no readings of {', '.join(unread)}, and torques depend on all joints"
        longest = max(float(np.ptp(self.log.time_s[rows])) for rows in self.log.stretches)
        short = "no series is longer than a second, too short for velocities"
        return short if longest <= 1.0 else "the arm stands still, or jerks, in all rows"

    @property
    def direction(self) -> Array:
        """Direction of motion, -1 to 1, 0 at rest."""
        return np.tanh(self.speed / STANDS_RAD_S)

    @cached_property
    def approach(self) -> Array:
        """Direction of each joint's last motion, -1 to 1, also at rest; 0 until the first motion of a run."""
        ahead, joints = np.empty_like(self.log.q), self.log.q.shape[1]
        for rows in self.log.rows_of_runs:
            ahead[rows] = play(self.log.q[rows].T, np.zeros(joints), np.full(joints, TURNS_RAD)).T
        return np.nan_to_num(-ahead[self.rows] / TURNS_RAD)

    @property
    def carried(self) -> Array:
        """Torque at each joint, as recorded or else of the rigid arm, (n, j) [Nm]."""
        recorded = self.log.tau[self.rows]
        is_known = np.isfinite(recorded) & (self.log.has_signs and self.log.torque_unit == "Nm")
        return np.where(is_known, recorded, self.rigid)

    @property
    def moves(self) -> Bools:
        """Which joints move by more than their noise, (j,)."""
        return np.asarray(np.ptp(self.q, axis=0) > SPANS_RAD)

    @cached_property
    def rigid_rate(self) -> Array:
        """Change of `rigid` with time, between the rows before and after [Nm/s]; 0 where the speed there is unknown."""
        log, rows = self.log, self.rows
        before, after = np.maximum(rows - 1, 0), np.minimum(rows + 1, len(log) - 1)
        before, after = (np.where(log.run[near] == log.run[rows], near, rows) for near in (before, after))
        earlier, later = (_rigid(log, near, *self.turning) for near in (before, after))
        return np.nan_to_num((later - earlier) / (log.time_s[after] - log.time_s[before])[:, None])

    def regressor(self, joint: int) -> Array:
        """Torques for a unit of mass, first moments and inertia of the link behind a joint, (n, j, 10)."""
        arm = self.log.robot.by_pinocchio
        return arm.torque_regressor(self.q, self.speed, self.acceleration, arm.columns[joint])

    def inertial_numbers(self, joint: int) -> Array:
        """Mass, first moments and inertia of that link by the URDF, (10,)."""
        arm = self.log.robot.by_pinocchio
        return arm.inertial_numbers(arm.columns[joint])

    @cached_property
    def masses(self) -> Array:
        """Mass on each joint by the URDF, (j,) [kg]."""
        return self.log.robot.carried(self.q[:1])[0]

    @cached_property
    def reach(self) -> float:
        """Largest distance of the flange from the base [m]."""
        return float(np.linalg.norm(self.log.robot.forward(self.q)[:, :3, 3], axis=1).max(initial=0.0))

    def payload(self) -> Array:
        """Torques for a kilogram at the flange's origin and for its first moments in the flange frame, (n, j, 4)."""
        return _payload(self.log.robot, self.q, self.speed, self.acceleration)


def quantities(log: MotionLog, kind: str) -> Quantities:
    """The rows of a kind, torques or differences of encoders, with the quantities of all joints for their columns."""
    read = np.asarray(np.isfinite(log.q).all(axis=1))
    if read.any():
        log = log.of_rows(read)
    speed, acceleration, inner, noise = derivatives(log)
    measured = log.tau if kind == "torque" else log.load - log.q
    if kind == "torque":  # friction at rest may be anything up to that in motion
        moves = np.ptp(log.q, axis=0) > SPANS_RAD
        measured = np.where((np.abs(speed) < STANDS_RAD_S) & moves, np.nan, measured)
    usable = inner & np.isfinite(speed + log.q).all(axis=1) & np.isfinite(measured).any(axis=1)
    number = np.flatnonzero(usable)
    number = number[:: max(1, -(-len(number) // MOST_ROWS))]
    rigid = _rigid(log, number, speed, acceleration)
    noise = _torque_noise(log.robot, log.q[number], noise)
    return Quantities(log, number, (speed, acceleration), rigid, measured[number], noise, kind)


def _rigid(log: MotionLog, rows: Ints, speed: Array, acceleration: Array) -> Array:
    """Torques of the rigid arm with the stated payload in some rows of a log, (n, j) [Nm]."""
    motion = log.q[rows], speed[rows], acceleration[rows]
    torques = log.robot.by_pinocchio.inverse_dynamics(*motion)
    if not log.payload_kg:
        return torques
    stated = np.array([log.payload_kg.get(name, 0.0) for name in log.series])[log.run[rows], None]
    return np.asarray(torques + stated * _payload(log.robot, *motion)[..., 0])


def _payload(robot: Robot, q: Array, speed: Array, acceleration: Array) -> Array:
    """Torques for a kilogram at the flange's origin and for its first moments in the flange frame, (n, j, 4)."""
    arm = robot.by_pinocchio
    return np.asarray(arm.torque_regressor(q, speed, acceleration, arm.tip) @ _of_point(arm.end))


def derivatives(log: MotionLog) -> tuple[Array, Array, Bools, Array]:
    """Velocities and accelerations of the joints by the parabolas through their readings (Savitzky, Golay 1964).

    Stamps that jitter are those of an even grid; where rows are missing, the parabolas are along the stamps.

    Returns:
        Both (n, j), NaN in runs that are too short and at pauses; which rows are away from the ends
        of their runs, (n,); and the noise of the accelerations, (j,) [rad/s²].
    """
    width = max(5, smoothed_rows(log.step_s))
    edge = max(width, round(EDGE_S / max(log.step_s, 1e-4)))
    speed, acceleration = (np.full_like(log.q, np.nan) for _ in range(2))
    inner, rough = np.zeros(len(log), dtype=bool), np.full_like(log.q, np.nan)
    about = np.arange(width) - width // 2
    even = _weights(np.linspace(about[0], about[-1], width)[None] * log.step_s, log.step_s)[0]
    for rows in log.stretches:
        if rows.stop - rows.start <= 2 * edge:
            continue
        q = np.nan_to_num(log.q[rows])  # of joints that were never read
        last = len(q) - 1
        read = np.stack([[np.convolve(joint, one[::-1], "same") for joint in q.T] for one in even]).swapaxes(1, 2)
        late = np.diff(log.time_s[rows], prepend=log.time_s[rows.start]) > MISSES * log.step_s
        odd = np.flatnonzero(np.convolve(late, np.ones(width), "same") > 0.5)
        odd = odd[(odd >= edge) & (odd < len(q) - edge)]
        ends = np.flatnonzero(np.minimum(np.arange(len(q)), last - np.arange(len(q))) < width // 2)
        for which, time_s in ((odd, log.time_s[rows]), (ends, log.step_s * np.arange(len(q)))):
            for some in np.array_split(which, 1 + len(which) // MOST_ROWS):
                around = np.clip(some, width // 2, last - width // 2)[:, None] + about
                read[:, some] = np.moveaxis(_weights(time_s[around] - time_s[some, None], log.step_s) @ q[around], 1, 0)
        smooth, speed[rows], acceleration[rows] = read
        rough[rows] = q - smooth
        inner[rows.start + edge : rows.stop - edge] = True
    inner &= ~_jerks(rough, width)
    noise = root_mean_squares(rough[inner]) / np.sqrt(1.0 - even[0].max()) * np.linalg.norm(even[2])
    return speed, acceleration, inner, noise


def _weights(time_s: Array, step_s: float) -> Array:
    """Weights of readings at times (n, w) in the value of the cubic through them at time zero, its slope and its bend.

    Returns:
        (n, 3, w); NaN where the readings span twice the time of as many even steps: a cubic does not know the motion
        between these.
    """
    reach = 0.5 * (time_s.shape[1] - 1) * step_s
    weights = np.linalg.pinv((time_s / reach)[..., None] ** np.arange(4))[:, :3] / reach ** np.arange(3)[:, None]
    weights[:, 2] *= 2.0
    weights[np.ptp(time_s, axis=1) > 4.0 * reach] = np.nan
    return np.asarray(weights)


def smoothed_rows(step_s: float) -> int:
    """Number of rows in a parabola."""
    return 2 * round(SMOOTHED_S / max(step_s, 1e-4) / 2) + 1


def _jerks(rough: Array, width: int) -> Bools:
    """Rows at which some joint moves too fast for a parabola, (n,): it sticks and slips."""
    size = np.abs(rough)
    jerk = (size > JERKS * medians(size)).any(axis=1)
    return np.convolve(jerk, np.ones(width), "same") > 0.5


def _torque_noise(robot: Robot, q: Array, noise: Array) -> Array:
    """Noise of the rigid arm's torques, (j,), by that of accelerations, (j,)."""
    some = q[:: max(1, len(q) // INERTIA_ROWS)]
    still, arm = np.zeros_like(some), robot.by_pinocchio
    rest = arm.inverse_dynamics(some, still, still)
    inertia = [arm.inverse_dynamics(some, still, still + one) - rest for one in np.eye(q.shape[1])]
    return np.asarray(np.sqrt(np.einsum("knj,k->j", np.square(inertia), np.nan_to_num(noise) ** 2) / max(1, len(some))))


def at_joint(of: Quantities, joint: int, values: Array) -> Array:
    """Columns of one joint's rows, (n,) or (n, k) -> (n, j, k)."""
    values = values[:, None] if values.ndim == 1 else values
    out = np.zeros((*of.q.shape, values.shape[1]))
    out[:, joint] = values
    return out


def of_joint(values: Callable[[Quantities], Array]) -> Callable[[Quantities, int], Sequence[Array]]:
    """The columns of an effect with one number: a quantity (n, j) at its joint."""
    return lambda of, joint: [at_joint(of, joint, values(of)[:, joint])]


def hardly_moves(of: Quantities, joint: int) -> str:
    """Reason why an effect cannot be tested on a joint: it has to move."""
    return "" if of.moves[joint] else "the joint hardly moves"


def _of_point(T: Array) -> Array:
    """Ten inertial numbers about the last joint, for mass and first moments in the flange frame, (10, 4)."""
    R, t = T[:3, :3], T[:3, 3]
    inertia = [t @ t * np.eye(3) - np.outer(t, t)]
    inertia += [2.0 * (t @ r) * np.eye(3) - np.outer(t, r) - np.outer(r, t) for r in R.T]
    xx_to_zz = np.array(inertia)[:, [0, 0, 1, 0, 1, 2], [0, 1, 1, 2, 2, 2]]
    return np.concatenate([[[1.0, 0.0, 0.0, 0.0]], np.column_stack([t, R]), xx_to_zz.T])
