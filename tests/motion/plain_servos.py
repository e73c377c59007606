"""Servos simulated by Euler's method, each with numeric faults; they share no code with robolaser."""

import numpy as np
from moved_arms import JOINTS, ROBOT

from robolaser.motion.log import MotionLog

LIFT = JOINTS.index("lift")
STEPS_HZ, RATE_HZ, NOISE_RAD = 2000, 100, 2e-5


def late_arm(
    lag_s: float = 0.0, delay_s: float = 0.0, zero: float = 0.0, dead: float = 0.0, *, seconds: float = 2.0
) -> MotionLog:
    """Eight runs of sines; the lift has a servo with these parameters, the other joints are ideal.

    The setpoint of the lift up to each row is the command of that row.
    """
    rng = np.random.default_rng(0)
    time = np.arange(round(seconds * STEPS_HZ)) / STEPS_HZ
    every = STEPS_HZ // RATE_HZ
    ahead = np.minimum(-(-np.arange(len(time)) // every) * every, len(time) - every)
    sent = np.maximum(ahead - round(delay_s * STEPS_HZ), 0)
    commands, readings = [], []
    for _ in range(8):
        amplitude = rng.uniform(0.2, 0.5, (4, 4)) / np.arange(1, 5)[:, None]
        rate, phase = 2.0 * np.pi * rng.uniform(0.05, 0.6, (4, 4)), rng.uniform(0.0, 2.0 * np.pi, (4, 4))
        begin = 0.5 - 0.5 * np.cos(np.pi * np.clip(time, 0.0, 1.0))[:, None]
        waves = (amplitude * np.sin(rate * time[:, None, None] + phase)).sum(axis=1)
        command = rng.uniform(-0.4, 0.4, 4) + np.array([0.0, 0.7, 0.6, 0.0]) + begin * waves
        q = command.copy()
        wanted = zero + command[sent, LIFT]
        q[0, LIFT] = wanted[0]
        for i in range(1, len(time)):
            error = wanted[i] - q[i - 1, LIFT]
            error = np.sign(error) * max(abs(error) - dead, 0.0)
            q[i, LIFT] = q[i - 1, LIFT] + (error / STEPS_HZ / lag_s if lag_s else error)
        commands.append(command[::every])
        readings.append(q[::every])
    goal, read = np.concatenate(commands), np.concatenate(readings)
    none, rows = np.full_like(read, np.nan), len(commands[0])
    return MotionLog(
        name="plain", robot=ROBOT, series=tuple("abcdefgh"), run=np.repeat(np.arange(8), rows),
        time_s=np.tile(np.arange(rows) / RATE_HZ, 8), command=goal, q=read + NOISE_RAD * rng.normal(size=read.shape),
        qd=none, tau=none, load=none,
    )  # fmt: skip
