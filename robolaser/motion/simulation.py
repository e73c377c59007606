"""Logs of simulated moving arms, as a real controller would write them, with chosen effects."""

from collections.abc import Mapping
from dataclasses import replace
from typing import Any

import numpy as np

from robolaser.arrays import Array
from robolaser.errors import UsageError, check_seed, near
from robolaser.motion.effect import At, MotionEffect, RowKind
from robolaser.motion.effects import library_of
from robolaser.motion.linear_rows import LinearRows
from robolaser.motion.log import ENCODER_RAD, MotionLog
from robolaser.motion.quantities import Quantities, derivatives
from robolaser.motion.servo import CommandSeries, smoothed
from robolaser.robot.kinematics import Robot

RATE_HZ = 100.0
DURATION_S = 20.0
SPAN_RAD = 0.8  # of a joint's motion about the middle of its range, at most
KNOT_S = 2.0
MOVE_S = 1.2  # of the time between two rests; the least jerk for it (Flash, Hogan 1985)
CORNER_S = 0.3  # in which a speed changes
TORQUE_NM = 0.02


def simulate_motion(
    robot: Robot, *, series: int = 6, effects: Mapping[str, float] | None = None, seed: int = 1, name: str = ""
) -> MotionLog:
    """Move an arm along sines, from rest to rest and at constant speeds; log commands, both encoders and torques.

    Args:
        robot: Any arm; without masses in its URDF its torques are those of friction alone.
        series: Number of runs.
        effects: Sizes by `NAME[:WHERE[.NUMBER]]`, of the effect's first number where none is named [SI]. Without a
            location an effect is at every joint where it can be.
        seed: Of motions and noise.
        name: Of the log.

    Raises:
        UsageError: There is no such effect, location or number, or the size is out of bounds.
    """
    check_seed(seed)
    rng = np.random.default_rng(seed)
    n = round(DURATION_S * RATE_HZ)
    time = np.arange(n) / RATE_HZ
    low, high = robot.by_pinocchio.limits
    columns = robot.by_pinocchio.columns
    low, high = np.maximum(low[columns], -np.pi), np.minimum(high[columns], np.pi)
    middle, half = (low + high) / 2.0, np.minimum(SPAN_RAD, 0.4 * (high - low))
    runs = [_motion(kind % 3, time, middle, half, rng) for kind in range(series)]
    command = np.concatenate(runs)
    run = np.repeat(np.arange(series), n)
    names = tuple(f"run_{number + 1}" for number in range(series))
    requested = _requested(robot, effects or {})
    q = _followed(robot, runs, time, requested["tracking"])
    empty = np.full_like(q, np.nan)
    log = MotionLog(
        name=name or f"simulated-{robot.name}", robot=robot, series=names,
        run=run, time_s=np.tile(time, series), command=command, q=q, qd=empty, tau=empty, load=empty,
    )  # fmt: skip
    speed, acceleration, _, noise = derivatives(log)
    rigid = robot.by_pinocchio.inverse_dynamics(q, speed, acceleration)
    of = Quantities(log, np.arange(len(run)), (speed, acceleration), rigid, rigid, noise)
    tau = rigid + _added(of, requested["torque"])
    load = q + _added(of, requested["load"])
    q, tau, load = (values + sigma * rng.normal(size=q.shape) for values, sigma in
             ((q, ENCODER_RAD), (tau, TORQUE_NM), (load, ENCODER_RAD)))  # fmt: skip
    return replace(log, q=q, qd=speed, tau=tau, load=load)


def _motion(kind: int, time: Array, middle: Array, half: Array, rng: np.random.Generator) -> Array:
    """Commands of all joints in one run, (n, j): sines, moves with rests between them, or speeds that are held."""
    joints = len(middle)
    if kind == 0:
        periods = rng.uniform(2.0, 8.0, (3, joints))
        phase = rng.uniform(0.0, 2.0 * np.pi, (3, joints))
        waves = np.sin(2.0 * np.pi * time[:, None, None] / periods + phase)
        return np.asarray(middle + half * waves.mean(axis=1))
    knots = np.arange(0.0, time[-1] + 2.0 * KNOT_S, KNOT_S)
    goals = middle + half * rng.uniform(-1.0, 1.0, (len(knots), joints))
    if kind == 1:
        before = np.searchsorted(knots, time, side="right") - 1
        s = np.clip((time - knots[before]) / MOVE_S, 0.0, 1.0)[:, None]
        return np.asarray(goals[before] + (goals[before + 1] - goals[before]) * s**3 * (10.0 - 15.0 * s + 6.0 * s**2))
    ramps = np.stack([np.interp(time, knots, goal) for goal in goals.T], axis=1)
    return smoothed(ramps, round(CORNER_S * RATE_HZ))


def _requested(robot: Robot, sizes: Mapping[str, float]) -> dict[RowKind, list[tuple[At, dict[str, float]]]]:
    """Effects at their locations with their numbers."""
    found: dict[RowKind, dict[str, tuple[At, dict[str, float]]]] = {"tracking": {}, "torque": {}, "load": {}}
    for text, size in sizes.items():
        name, _, place = text.partition(":")
        where, _, number = place.partition(".")
        kinds = library_of([name])
        there = {one: list(robot.joints) if one.site == "joint" else [one.site] for one in kinds}
        fitting = [one for one in kinds if not where or where in there[one]]
        if not fitting:
            every = dict.fromkeys(place for places in there.values() for place in places)
            raise UsageError(f"{name} has no location '{where}'.{near(where, list(every))}")
        effect = next((one for one in fitting if number in {each.name for each in one.numbers}), fitting[0])
        for one in [where] if where else there[effect]:
            joint = robot.joints.index(one) if one in robot.joints else 0
            at = At(effect, one, joint)
            _, numbers = found[effect.rows].setdefault(str(at), (at, {}))
            known = [each.name for kind in kinds for each in kind.numbers]
            if number and number not in known:
                raise UsageError(f"{name} has no number '{number}'.{near(number, known)}")
            numbers[number or known[0]] = _within_bounds(effect, number or known[0], float(size))
    return {kind: list(group.values()) for kind, group in found.items()}


def _within_bounds(effect: MotionEffect, number: str, size: float) -> float:
    """The size of an effect's number, checked against its bounds."""
    one = next((one for one in effect.numbers if one.name == number), None)
    if one is not None and not one.lower <= size <= one.upper:
        unit = f" {one.unit}".rstrip()
        raise UsageError(
            f"{effect.name}: {number} is {size:g}{unit}, but its bounds are {one.lower:g} and {one.upper:g}{unit}."
        )
    return size


def _followed(robot: Robot, runs: list[Array], time: Array, requested: list[tuple[At, dict[str, float]]]) -> Array:
    """Angles of the joints, (n, j)."""
    joints, step_s = len(robot.joints), time[1] - time[0]
    servos: list[dict[str, Any]] = [{} for _ in range(joints)]
    for at, numbers in requested:
        given = {one.servo: numbers[one.name] for one in at.effect.numbers if one.name in numbers}
        for joint in [at.joint] if at.effect.site == "joint" else range(joints):
            servos[joint] |= {name: servos[joint].get(name, 0.0) + value for name, value in given.items()}
    sent = CommandSeries.of(robot, runs, np.full((len(time), len(runs)), step_s), step_s)
    paths = sent.simulate(np.arange(joints), servos)
    return np.concatenate(list(paths.transpose(1, 0, 2)))


def _added(of: Quantities, requested: list[tuple[At, dict[str, float]]]) -> Array:
    """Contribution of linear effects to rows, (n, j)."""
    rows = LinearRows(of, of.measured, [at for at, _ in requested])
    out = np.zeros(of.q.shape)
    for at, numbers in requested:
        values = np.array([numbers.get(one.name, 0.0) for one in at.effect.numbers])
        out += rows.columns(at, 0) @ values
    return out
