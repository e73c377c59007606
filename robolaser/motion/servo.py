"""Model of a joint's response to commands: a servo with dead time, lag, droop, dead zone, play and limits.

    u = clip((1 + scale) c(t - dead_time) + offset - droop g(c(t - dead_time)) + bend(c(t - dead_time)), lower, upper)
    second z'' + lag z' = D(u - z), |z'| <= speed,  D(e) = sign(e) max(|e| - dead_zone, 0)
    q = z as far as play does not hold it back

Armstrong-Hélouvry, Dupont, Canudas de Wit 1994, A survey of models, analysis tools and compensation methods for the
control of machines with friction; Nordin, Gutman 2002, Controlling mechanical systems with backlash.
"""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from itertools import pairwise
from typing import Self, final

import numpy as np

from robolaser.arrays import Array, Ints
from robolaser.motion.quantities import smoothed_rows
from robolaser.robot.kinematics import Robot

DEGREE = 5
"""Of polynomials in place of functions of unknown form. A judgement: a sine over two radians is within 1e-4 of one."""
BENDS = tuple(f"bend_{degree}" for degree in range(DEGREE + 1))
"""Factors [rad] of Chebyshev polynomials of a joint's commands."""
IDEAL: Mapping[str, float] = {
    **dict.fromkeys(BENDS, 0.0),
    "delay": 0.0, "time": 0.0, "second": 0.0, "angle": 0.0, "scale": 0.0, "compliance": 0.0, "yields": 0.0, "dead": 0.0,
    "lost": 0.0, "speed": np.inf, "lower": -np.inf, "upper": np.inf,
}  # fmt: skip
"""Numbers of a servo that follows its command."""
SHORTEST_LAG_S = 1e-6
STEP_DIGITS = 5  # of seconds: resolution of time steps
MOST_CELLS = 30_000_000  # simulated at a time


@final
@dataclass(frozen=True, eq=False)
class CommandSeries:
    """Commands for a simulation, runs side by side, the longest first: (t, s), each continued by its last one."""

    length: Ints  # rows of each run, (s,)
    step: Array  # from each row to the next, (t, s) [s]
    command: Array  # (j, t, s) [rad]
    holding: Array  # gravity torque at the commanded position, (j, t, s) [Nm]
    moving: Array  # torque of the rigid arm along the commands, (j, t, s) [Nm]
    start: Array  # angle of each joint at the beginning, (j, s) [rad]
    rate: Array  # speed of it and its commands until then, (j, s) [rad/s]

    @classmethod
    def of(cls, robot: Robot, commands: Sequence[Array], step: Array, step_s: float) -> Self:
        """Runs from rest by their commands, (n, j) each, the longest first; NaN where a joint has none.

        Steps are from each row to the next, (t, s) [s]; `step_s` is the usual one.
        """
        sent, holding, moving = np.empty((3, len(robot.joints), *step.shape))
        for s, command in enumerate(commands):
            held = np.nan_to_num(command)
            torques = robot.gravity_torques(held), _torques_along(robot, held, step_s)
            for values, of_run in zip((sent, holding, moving), (command, *torques), strict=True):
                values[:, : len(command), s] = of_run.T
                values[:, len(command) :, s] = of_run[-1][:, None]
        length, start = np.array(list(map(len, commands))), sent[:, 0]
        return cls(length, step, sent, holding, moving, start, np.zeros_like(start))

    def simulate(self, joint: Ints, numbers: Sequence[Mapping[str, float]]) -> Array:
        """Simulate cases, a joint (m,) and its servo's numbers each, (t, s, m) [rad].

        Other numbers are those of an ideal servo.
        """
        rows, runs = self.step.shape
        share = max(1, MOST_CELLS // (rows * runs))
        parts = [
            self._simulated(joint[first : first + share], numbers[first : first + share])
            for first in range(0, len(joint), share)
        ]
        return np.concatenate(parts, axis=2)

    def _wanted(self, joint: Ints, of: Mapping[str, Array], time: Array) -> Array:
        """Angles that the servos approach, (t, s, m)."""
        wanted = np.empty((*self.step.shape, len(joint)))
        for m, (j, delay) in enumerate(zip(joint, of["delay"], strict=True)):
            seen = (1.0 + of["scale"][m]) * self.command[j] + of["angle"][m]
            seen -= of["compliance"][m] * self.holding[j] + of["yields"][m] * self.moving[j]
            if any(bends := [of[name][m] for name in BENDS]):
                seen += np.polynomial.chebyshev.chebval(over_range(self.command[j]), bends)
            wanted[:, :, m] = _later(seen, delay, time, (1.0 + of["scale"][m]) * self.rate[j])
        np.clip(wanted, of["lower"], of["upper"], out=wanted)
        return wanted

    def _simulated(self, joint: Ints, numbers: Sequence[Mapping[str, float]]) -> Array:
        of = {name: np.array([one.get(name, ideal) for one in numbers]) for name, ideal in IDEAL.items()}
        rows, runs = self.step.shape
        passed = np.concatenate([self.step[:1], self.step[:-1]])  # from the row before to each
        wanted = self._wanted(joint, of, np.cumsum(passed, axis=0))
        dead, lost, fastest = (np.tile(of[name], runs) for name in ("dead", "lost", "speed"))
        within = -dead
        answer = _Answer.of(passed, of["time"], of["second"])
        rests, plays, limited = bool(dead.any()), bool(lost.any()), bool(np.isfinite(fastest).any())
        flat = wanted.reshape(rows, -1)
        begun = np.clip(self.start[joint], of["lower"][:, None], of["upper"][:, None])  # within limits
        followed = begun.T.ravel().copy()
        shown, speed = followed.copy(), self.rate[joint].T.ravel()
        off, part = np.empty_like(followed), np.empty_like(followed)
        going = np.searchsorted(-self.length, -np.arange(rows), side="left") * len(joint)
        for first, last in answer.alike(going):
            n = int(going[first])
            z, v, e, p, y = followed[:n], speed[:n], off[:n], part[:n], shown[:n]
            approach, *of_speed = answer.at(first, n)
            for i in range(first, last):  # ufuncs write into allocated memory: this loop is most of a diagnosis
                u = flat[i, :n]
                np.subtract(u, z, out=e)
                if rests:
                    np.maximum(e, within[:n], out=p)
                    np.minimum(p, dead[:n], out=p)
                    e -= p
                if of_speed:
                    coasting, pulled, kept = of_speed
                    np.multiply(coasting, v, out=p)
                    v *= kept
                    np.multiply(pulled, e, out=u)
                    v += u
                    e *= approach
                    e += p
                else:
                    e *= approach
                if limited:
                    np.multiply(passed[i].repeat(len(joint))[:n], fastest[:n], out=p)
                    np.minimum(e, p, out=e)
                    np.maximum(e, np.negative(p, out=p), out=e)
                if limited and of_speed:
                    np.minimum(v, fastest[:n], out=v)
                    np.maximum(v, -fastest[:n], out=v)
                z += e
                if plays:
                    np.maximum(y, z - lost[:n], out=y)
                    np.minimum(y, z + lost[:n], out=y)
                u[:] = y if plays else z
        return wanted


@final
@dataclass(frozen=True, eq=False)
class _Answer:
    """Share of the way to the target that joints move in a time step: exact where the lag is linear."""

    which: Ints  # of the steps' lengths, at each row of each run, (t, s)
    parts: tuple[Array, ...]  # of the way; where joints coast, of the speed, too, and by which both change the speed

    @classmethod
    def of(cls, step: Array, time: Array, second: Array) -> "_Answer":
        """For steps (t, s) and cases (m,) of S z'' + T z' + z = u: parts (lengths, m)."""
        lengths, which = np.unique(np.round(step, STEP_DIGITS), return_inverse=True)
        h, T, S = lengths[:, None], np.maximum(time, SHORTEST_LAG_S), np.maximum(second, SHORTEST_LAG_S**2)
        root = np.sqrt(np.where(np.abs(T**2 - 4.0 * S) < 1e-6 * S, 1e-6 * S, T**2 - 4.0 * S) + 0.0j)
        slow, fast = -2.0 / (T + root), -(T + root) / (2.0 * S)
        a, b, gap = np.exp(slow * h), np.exp(fast * h), slow - fast
        coasting = ((a - b) / gap).real
        parts = (1.0 - ((slow * b - fast * a) / gap).real, coasting, coasting / S, ((slow * a - fast * b) / gap).real)
        return cls(which.reshape(step.shape), parts if second.any() else parts[:1])

    def alike(self, going: Ints) -> list[tuple[int, int]]:
        """First row, and the one after the last, of each series of rows with equal steps and running cases, (t,)."""
        changes = (np.diff(self.which, axis=0) != 0).any(axis=1) | (np.diff(going) != 0)
        bounds = [0, *(np.flatnonzero(changes) + 1).tolist(), len(going)]
        return list(pairwise(bounds))

    def at(self, row: int, count: int) -> list[Array]:
        """The parts at a row, for the first cases of all runs."""
        return [part[self.which[row]].ravel()[:count] for part in self.parts]


def _later(values: Array, delay: float, time_s: Array, rate: Array) -> Array:
    """Values (t, s) as they were some time [s] before, between two of them and, at rates (s,), before them straight."""
    if not delay:
        return values
    shifted = time_s - delay
    found = [np.interp(at, t, v) for at, t, v in zip(shifted.T, time_s.T, values.T, strict=True)]
    return np.asarray(np.stack(found, axis=1) + rate * np.minimum(shifted - time_s[0], 0.0))


def over_range(values: Array) -> Array:
    """Values scaled to -1 to 1."""
    return np.asarray((2.0 * values - values.max() - values.min()) / max(float(np.ptp(values)), 1e-12))


def _torques_along(robot: Robot, command: Array, step_s: float) -> Array:
    """Torque of the rigid arm along smoothed commands (n, j), (n, j) [Nm]."""
    width = smoothed_rows(step_s)
    if len(command) < 2 * width:
        return robot.gravity_torques(command)
    smooth = smoothed(command, width)
    speed = np.gradient(smooth, step_s, axis=0)
    return robot.by_pinocchio.inverse_dynamics(smooth, speed, np.gradient(speed, step_s, axis=0))


def smoothed(values: Array, width: int) -> Array:
    """Values (n, j) smoothed by a bell of so many rows, (n, j); the ends are held."""
    weights = np.hanning(width + 2)[1:-1]
    padded = np.pad(values, ((width // 2, (width - 1) // 2), (0, 0)), mode="edge")
    return np.stack([np.convolve(column, weights / weights.sum(), "valid") for column in padded.T], axis=1)
