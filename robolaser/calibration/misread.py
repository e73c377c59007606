"""Data that do not mean what they say: joints exchanged or in degrees, poses inverted, rows one pose off."""

from collections.abc import Iterator
from dataclasses import dataclass, replace
from itertools import combinations
from typing import Literal, final

import numpy as np

from robolaser.arrays import Array, Bools, Ints
from robolaser.calibration.checks import SETUP_RMS_M
from robolaser.data.dataset import Dataset
from robolaser.errors import RobolaserError
from robolaser.estimation.multistart import subsampled
from robolaser.estimation.problem import Problem
from robolaser.estimation.solver import solve
from robolaser.geometry.rigid_motion import inverse
from robolaser.model.forward_model import Model
from robolaser.model.sensors.mounting import Mounting

FALLS = 5.0
"""Factor by which another reading of the joints must lower the error before it is said. A judgement: exchanged columns
leave centimetres or more, the largest effects of the library millimetres."""
BEST = 3.0  # factor by which the error of any other hypothesis must be larger: else it is not known what is wrong
FAR_OUTSIDE = 1.0  # how far a joint may stand outside its limits under a hypothesis [rad or m], as in `poses.csv`
STEPS = 12  # of each descent; an error that has not fallen by then is no sign
COARSE = 1e-6
FEWEST_POSES = 6  # of which rows may be one pose off
DEGREE = np.pi / 180.0


@final
@dataclass(frozen=True)
class Misreading:
    """Another way to read the joints of `poses.csv`."""

    columns: tuple[int, ...]  # which column each joint's reading is from, (j,)
    factors: tuple[float, ...]  # what it is multiplied by, (j,)
    fault: str  # what is then wrong with the file: the beginning of a sentence

    def of(self, values: Array) -> Array:
        """Readings or velocities (n, j) as they are meant."""
        meant: Array = values[:, list(self.columns)] * np.array(self.factors)
        return meant


@final
@dataclass(frozen=True)
class Misread:
    """Data that fit far better when they are read otherwise."""

    sentence: str
    shift: int  # by how many poses the rows of points.csv are off; 0 where something else is wrong


def misread(model: Model, rms_m: float) -> Misread | None:
    """What seems to be read wrongly; None where the error is no sign of it, or nothing explains it.

    Each hypothesis is fitted to some rows from its own start values, in a few steps.

    Args:
        model: Data and effects.
        rms_m: Root-mean-square error of the fitted points; infinite where there is no fit.
    """
    if rms_m < SETUP_RMS_M:
        return None
    few = subsampled(model.with_effects(())).dataset
    readings = [*_otherwise(few), *(_of_joints(few) if few.robot is not None and few.poses.q is not None else ())]
    if not readings:
        return None
    as_read = _error(few)
    errors = np.array([_error(reading.dataset) for reading in readings])
    order = np.argsort(errors)
    best, second = errors[order[0]], errors[order[1:2]].min(initial=np.inf)
    if not np.isfinite(best) or best * FALLS > as_read or best * BEST > second:
        return None
    instead = f" instead of {_millimetres(as_read)}" if np.isfinite(as_read) else ""
    found = readings[int(order[0])]
    return Misread(
        f"{found.fault}: read otherwise, fitted points are {_millimetres(best)} off{instead}. Correct {found.where}.",
        found.shift,
    )


@final
@dataclass(frozen=True)
class _Hypothesis:
    """A data set read otherwise."""

    dataset: Dataset
    fault: str  # what is then wrong: the beginning of a sentence
    where: str = "poses.csv, or the file that it was made from"
    shift: int = 0


def _otherwise(dataset: Dataset) -> Iterator[_Hypothesis]:
    """Rows one pose off, flange poses the other way round, the sensor at the other end."""
    points, count = dataset.points, len(dataset.poses)
    for shift, which in ((1, "after"), (-1, "before")):
        pose = points.pose + shift
        kept = np.flatnonzero((pose >= 0) & (pose < count))
        if len(kept) and count > FEWEST_POSES:
            moved = replace(points.take(kept), pose=pose[kept])
            fault = f"The points, or images, seem to belong to the pose {which} theirs"
            yield _Hypothesis(replace(dataset, points=moved), fault, "the rows of poses.csv or points.csv", shift)
    T, options = dataset.poses.T_base_flange, dataset.options
    end: Literal["flange", "base"] = "flange" if getattr(options, "mount", "flange") == "base" else "base"
    if T is not None:  # a sensor at the other end sees the same with inverse poses
        inverted = replace(dataset, poses=replace(dataset.poses, T_base_flange=inverse(T)))
        mounted = f", or the sensor is mounted on the {end}" if isinstance(options, Mounting) else ""
        yield _Hypothesis(inverted, f"poses.csv seems to hold T_flange_base, the inverse of T_base_flange{mounted}")
    elif isinstance(options, Mounting):
        swapped = replace(dataset, options=replace(options, mount=end), parameters={}, placed=False)
        fault = f"The sensor seems to be mounted on the {end}"
        yield _Hypothesis(swapped, fault, "mount under [sensor] in dataset.toml")


def _of_joints(dataset: Dataset) -> Iterator[_Hypothesis]:
    for reading in _readings(dataset):
        yield _Hypothesis(_read_as(dataset, reading), reading.fault)


def _readings(dataset: Dataset) -> Iterator[Misreading]:
    """Hypotheses under which all joints stay near their limits."""
    robot, q = dataset.arm
    j, moves = len(robot.joints), np.ptp(q, axis=0) > 0
    whole, ones = tuple(range(j)), (1.0,) * j
    turning = np.flatnonzero(moves & ~robot.prismatic)
    for reading in (
        *_exchanged(robot.joints, robot.prismatic, moves),
        *(
            Misreading(whole, _but(ones, i, -1.0), f"q_{robot.joints[i]} seems to have the wrong sign")
            for i in np.flatnonzero(moves).tolist()
        ),
        *(
            Misreading(whole, _but(ones, i, DEGREE), f"q_{robot.joints[i]} seems to be in degrees")
            for i in turning.tolist()
        ),
        *_all_scaled(turning, ones, whole),
    ):
        meant = reading.of(q)
        if ((meant > robot.lower - FAR_OUTSIDE) & (meant < robot.upper + FAR_OUTSIDE)).all():
            yield reading


def _exchanged(joints: tuple[str, ...], prismatic: Bools, moves: Bools) -> Iterator[Misreading]:
    for a, b in combinations(range(len(joints)), 2):
        if prismatic[a] == prismatic[b] and (moves[a] or moves[b]):
            columns = list(range(len(joints)))
            columns[a], columns[b] = b, a
            fault = f"The columns q_{joints[a]} and q_{joints[b]} of poses.csv seem to be exchanged"
            yield Misreading(tuple(columns), (1.0,) * len(joints), fault)


def _all_scaled(turning: Ints, ones: tuple[float, ...], whole: tuple[int, ...]) -> Iterator[Misreading]:
    for factor, fault in (
        (DEGREE, "All angles of poses.csv seem to be in degrees"),
        (1 / DEGREE, "All angles of poses.csv seem to be divided by 57.3, as if they had been in degrees"),
    ):
        yield Misreading(whole, tuple(factor if i in turning else one for i, one in enumerate(ones)), fault)


def _but(ones: tuple[float, ...], i: int, factor: float) -> tuple[float, ...]:
    return (*ones[:i], factor, *ones[i + 1 :])


def _read_as(dataset: Dataset, reading: Misreading) -> Dataset:
    poses = dataset.poses
    assert poses.q is not None
    qd = None if poses.qd is None else reading.of(poses.qd)
    return replace(dataset, poses=replace(poses, q=reading.of(poses.q), qd=qd))


def _error(dataset: Dataset) -> float:
    """Root-mean-square error of the points after a short fit [m]; infinite where there is none."""
    try:
        model = Model(dataset)
        start = model.fix_gauge(model.parameters.nominal)
        end = solve(Problem.of(model), start[None], tol=COARSE, hopeless=_long_enough)
    except (RobolaserError, np.linalg.LinAlgError):
        return np.inf
    errors = model.in_metres(end.x[0], model.residuals(end.x)[0])
    error = float(np.sqrt((errors**2).sum(axis=-1).mean()))
    return error if np.isfinite(error) else np.inf


def _millimetres(length_m: float) -> str:
    return f"{1e3 * length_m:.0f} mm" if length_m >= 0.01 else f"{1e3 * length_m:.2g} mm"


def _long_enough(costs: Array, converged: Bools, steps: Ints) -> Bools:
    return np.asarray(steps >= STEPS)
