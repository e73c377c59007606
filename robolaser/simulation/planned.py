"""Measurements of a sensor at planned poses: without noise, in a cell like the simulated ones."""

from collections.abc import Iterator, Mapping
from dataclasses import dataclass, replace
from typing import final

import numpy as np

from robolaser.arrays import Array
from robolaser.data.dataset import Dataset, Points
from robolaser.data.sensor_format import Mount
from robolaser.errors import EstimationError
from robolaser.geometry.rigid_motion import from_angles, inverse, pose
from robolaser.model.sensors.placements import SIX, motion, numbers_of_motion
from robolaser.parameters import as_batch
from robolaser.simulation.sensors import simulated_sensor
from robolaser.simulation.setup import CellOptions, RandomStreams, SensorSetup

DRAWN = 8  # sensors that are drawn, at most: the mounting determines the view
TRIED = 4  # planned poses, and poses that see a target; pairs of both place it
MOVED = 1e-6  # move of a joint above which the measured pose differs: a socket determines the arm's posture [rad or m]
ENOUGH = 0.9  # share of the poses that see the target, above which no other placement is tried


@final
@dataclass(frozen=True)
class Planned:
    """A planned run with its measurements."""

    dataset: Dataset  # all poses, and the points of those that see the target
    truth: Mapping[str, float]  # every parameter of the sensor by name
    seeing: int  # how many poses see it


def planned(dataset: Dataset, *, points: int | None = None, mount: Mount = "flange", seed: int = 0) -> Planned:
    """Simulate measurements at a data set's planned poses.

    The sensor is the data set's if it states its parameters, else a usual one of its kind. An unplaced target is put
    where most poses see it, since its placement is unknown.

    Args:
        dataset: Poses of a robot, without points.
        points: In each pose; when absent, as in `simulate`.
        mount: Of a camera, unless the data set states it.
        seed: Of the drawn sensor.

    Raises:
        EstimationError: No pose sees anything.
        RobotError: The arm cannot look at any target.
        UsageError: Sensors of this kind cannot be simulated.
    """
    kind = simulated_sensor(dataset.kind)
    mount = getattr(dataset.options, "mount", mount)
    points = kind.default_points if points is None else points
    kind.check_counts(poses=len(dataset.poses), points=points, repeats=1)
    setup = SensorSetup(points, CellOptions(placed=False, mount=mount))
    blank = replace(dataset, points=Points(), placed=False)
    if not dataset.parameters:
        blank = kind.describe(blank, setup)
    stated = {name: item.nominal for name, item in dataset.parameters.items()}
    robot, q = dataset.arm
    flange = robot.forward(q)
    best, measured, truth = np.zeros(len(q), dtype=bool), blank, {}
    for number in range(DRAWN):
        sensor = kind.build(blank, setup, RandomStreams.of(seed + number))
        for placed in _placements({**sensor.truth, **stated}, flange, robot.forward(sensor.candidates)):
            seen, good = sensor.measure(blank, np.arange(len(q)), as_batch(placed), ())
            good = good & (np.abs(seen.arm[1] - q) < MOVED).all(axis=1)
            if good.sum() > best.sum():
                best, measured, truth = good, seen, placed
            if best.mean() >= ENOUGH:
                break
        if best.mean() >= ENOUGH:
            break
    if not best.any():
        raise EstimationError(
            f"A usual sensor of the kind {dataset.kind} sees nothing from these {len(q)} poses, wherever its target is"
            " put. Measure once in some of them, and plan from these data."
        )
    rows = np.flatnonzero(best[measured.points.pose])
    return Planned(replace(measured, points=measured.points.take(rows)), truth, int(best.sum()))


def _placements(truth: Mapping[str, float], flange: Array, there: Array) -> Iterator[dict[str, float]]:
    """The target as built; then in the same relation to planned poses as to those that see it, unchanged or levelled.

    By T_base_flange, (n, 4, 4) planned and (k, 4, 4) there.
    """
    yield dict(truth)
    if not all(f"target.{part}" in truth for part in SIX):
        return
    target = motion(as_batch(truth), "target")
    some = np.unique(np.linspace(0, len(flange) - 1, TRIED).astype(int))
    for i in some:
        for T_flange_target in inverse(there[:TRIED]) @ target:
            T = flange[i] @ T_flange_target
            heading = np.arctan2(T[1, 0], T[0, 0])
            level = pose(from_angles(np.zeros(()), np.zeros(()), heading), T[:3, 3])
            for placed in (T, level):
                yield {**truth, **numbers_of_motion(placed, "target")}
