"""Data sets as a real cell would give them, of any robot and with any departures from its nominal model."""

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field, fields, replace
from typing import final

import numpy as np

from robolaser.arrays import Array, Bools, Ints
from robolaser.data.dataset import Dataset, Noise, Points, Poses
from robolaser.data.sensor_format import sensor_kinds
from robolaser.errors import EffectError
from robolaser.geometry.inverse_kinematics import reaching, within_reach
from robolaser.geometry.kinematics import Robot
from robolaser.geometry.rigid_motion import from_angles, from_quaternion, pose
from robolaser.geometry.visibility import View, configurations_looking_down, limits, random_configurations
from robolaser.model.effects.effect import CandidateEffect
from robolaser.model.sensors.sensor import SIX
from robolaser.simulation.effect_specs import numbers_of
from robolaser.simulation.exact import seated, stripe_points, tracker_points
from robolaser.simulation.nominal import IMAGE_PX, Quaternion, built, facing_outward, scanner
from robolaser.simulation.outliers import impossible, share_of, spoil

TRAVEL = 0.3  # fastest joint's mean speed between poses [rad/s or m/s]
EXPOSURE_SPEED = 0.1  # joints' speed at the exposure, where an effect of the timing needs one [rad/s or m/s]
STRIPE_POINTS, OTHER_POINTS = 12, 3
JITTER = 0.6  # of the distance between points along the stripe
TILTED = 0.02  # an unplaced target lies askew by this at most [rad]
TRACKER_M = (2.5, -1.5, 1.2)  # where the base stands, seen from the tracker
REFLECTORS_M = (0.08, 0.12)  # distance of the reflectors from the flange's axis, least and most
BALL_M = (0.03, -0.02, 0.12)  # of the ball in the flange frame
HAND_MADE_M = 0.002  # how far tools are from where they were meant to be


@final
@dataclass(frozen=True)
class Simulated:
    """A simulated data set and what no cell would tell.

    Attributes:
        dataset: As the cell would give it.
        truth: Every parameter of the sensor, and the numbers of the effects, by name.
        effects: The effects that are in it.
        gross: Rows with gross errors.
    """

    dataset: Dataset
    truth: Mapping[str, float]
    effects: tuple[CandidateEffect, ...] = ()
    gross: Ints = field(default_factory=lambda: np.empty(0, dtype=np.int64))


@final
@dataclass(frozen=True)
class _Chances:
    """Separate sources of chance, so that one more draw here changes nothing there."""

    build: np.random.Generator
    place: np.random.Generator
    order: np.random.Generator
    along: np.random.Generator
    speed: np.random.Generator
    joint_noise: np.random.Generator
    point_noise: np.random.Generator
    gross: np.random.Generator


_Measure = Callable[[Ints, Dataset], tuple[Dataset, Bools]]
"""Chosen candidates, and a data set that stands in them, to its points and which poses did their job."""


@final
@dataclass(frozen=True)
class _World:
    """What a kind of sensor needs: the sensor's truth, postures that suit it, and how it measures there."""

    truth: Mapping[str, float]
    candidates: Array
    measure: Callable[[Mapping[str, Array], Sequence[CandidateEffect]], _Measure]


def simulate(
    robot: Robot,
    *,
    kind: str = "stripe",
    poses: int = 40,
    points: int | None = None,
    repeats: int = 1,
    noise: Noise | None = None,
    stated: Noise | None = None,
    effects: Mapping[str, float] | None = None,
    placed: bool = True,
    level: float | None = None,
    stripe_axis: str = "u",
    bracket_quat: Quaternion | None = None,
    pause_s: float = 30.0,
    speed: float | None = None,
    name: str = "",
    seed: int = 0,
) -> Simulated:
    """What a cell would record, its scanner built with the tolerances of `nominal.BUILT`.

    The arm visits random postures within its limits in which it can measure. Truth is exact: without noise, the model
    with the true parameters and effects leaves nothing.

    Args:
        robot: The nominal arm.
        kind: "stripe", "point" (a tracker) or "socket".
        poses: How many.
        points: Of a stripe in each pose (12 when absent); reflectors on the flange, or sockets in the cell (3).
        repeats: PoseImages at each unmoved pose.
        noise: What chance adds; nothing when absent. A stripe's target error is shared by a point's repeats.
        stated: What the data set says of it; all of `noise` when absent.
        effects: Sizes by NAME[:WHERE[.NUMBER]]: without NUMBER the principal one, without WHERE at every place.
            `outliers` is the share of rows with gross errors.
        placed: Whether target points are given in the base frame, or in their own (stripe only).
        level: Height of the target in the base frame [m]; when absent, one that the arm can look at.
        stripe_axis: Image axis the stripe runs along.
        bracket_quat: Nominal turn of the camera on the flange; when absent it looks away from the arm.
        pause_s: Time spent at each pose.
        speed: Joints' typical speed at the exposure [rad/s or m/s]. When absent the arm rests and no speed is
            recorded, save where an effect of the timing is asked for.
        name: Of the data set.
        seed: Same seed, same data set.

    Raises:
        RobotError: The arm cannot look at a target or reach a socket often enough.
        EffectError: With the effects it no longer can, or they are not possible.
        UsageError: Numbers or words that have no meaning here.
    """
    points = (STRIPE_POINTS if kind == "stripe" else OTHER_POINTS) if points is None else points
    noise = noise or Noise()
    _demand(kind, poses, points, repeats, noise)
    chances = _Chances(
        *(np.random.default_rng(child) for child in np.random.SeedSequence(seed).spawn(len(fields(_Chances))))
    )
    blank = Dataset(
        name=name or f"simulated-{robot.name}",
        source="simulated by robolaser",
        robot=robot,
        kind=kind,
        poses=Poses(tuple(map(str, range(poses)))),
        points=Points(np.empty(0, dtype=np.int64), ()),
        placed=placed or kind != "stripe",
        noise=stated or noise,
    )
    if kind == "stripe":
        bracket = facing_outward(robot) if bracket_quat is None else bracket_quat
        blank = replace(
            blank,
            stripe_axis=stripe_axis,
            bracket_quat=bracket,
            image_px=IMAGE_PX,
            parameters=scanner(bracket),
        )
        world = _stripe(blank, points, level, chances)
    else:
        world = (_tracker if kind == "point" else _sockets)(blank, points, chances)
    lower, upper = limits(robot)
    qd = chances.speed.uniform(-1.0, 1.0, (poses, len(lower))) * (EXPOSURE_SPEED if speed is None else speed)
    q = np.tile((lower + upper) / 2, (poses, 1))
    moving = replace(blank, poses=replace(blank.poses, time_s=_times(q, pause_s), q=q, qd=qd))
    asked = dict(effects or {})
    gross = share_of(asked)
    inside, numbers = numbers_of(asked, moving)
    if not speed and not (speed is None and any(candidate_effect.where == "timing" for candidate_effect in inside)):
        moving = replace(moving, poses=replace(moving.poses, qd=None))
    truth = {**world.truth, **numbers}
    values = {key: np.array([value]) for key, value in truth.items()}
    exact = _settled(moving, world.candidates, world.measure(values, inside), pause_s, chances.order)
    spoilt, rows = spoil(_noisy(exact, noise, repeats, chances), gross, chances.gross)
    return Simulated(spoilt, truth, inside, rows)


def paper(robot: Robot, *, effects: Mapping[str, float] | None = None, seed: int = 0) -> Simulated:
    """The experiment of the 2004 paper: 5 points in each of 5 poses, a target known to 0.3 mm, and no word on noise."""
    return simulate(
        robot,
        poses=5,
        points=5,
        noise=Noise(target_m=3e-4),
        stated=Noise(),
        effects=effects,
        name="paper",
        seed=seed,
    )


def _demand(kind: str, poses: int, points: int, repeats: int, noise: Noise) -> None:
    kinds = sensor_kinds()
    if kind not in kinds:
        raise impossible("sensor kind", kind, " or ".join(kinds))
    for what, count in (("poses", poses), ("points", points), ("repeats", repeats)):
        if count < 1:
            raise impossible(f"number of {what}", count, "1 or more")
    for what, sigma in vars(noise).items():
        if sigma is not None and not 0 < sigma < np.inf:
            raise impossible(f"noise {what} of", sigma, "a positive number, or nothing for none")
    if kind == "socket" and repeats > 1:
        raise impossible("number of repeats", repeats, "1: a seated ball is not shot at, each seat is a pose")
    if kind == "socket" and poses < points:
        raise impossible("number of poses", poses, f"at least one for each of {points} sockets")


def _stripe(blank: Dataset, points: int, level: float | None, chances: _Chances) -> _World:
    robot, n = _arm(blank), len(blank.poses)
    truth = built(blank.parameters, chances.build)
    bracket = from_quaternion(np.array(blank.bracket_quat))
    turn = from_angles(*(np.array(truth[angle]) for angle in ("w", "phi", "psi")))
    shift = np.array([truth[f"t_{axis}"] for axis in "xyz"])
    assert blank.image_px is not None  # said above
    view = View(pose(bracket @ turn, shift), truth, blank.stripe_axis, blank.image_px)
    candidates, height = configurations_looking_down(robot, view, wanted=n, level=level, rng=chances.place)
    first, last = view.stripe_range()
    step = (last - first) / points
    at = first + step * (np.arange(points) + 0.5 + JITTER * chances.along.uniform(-0.5, 0.5, (n, points)))
    if not blank.placed:
        middle = robot.forward(candidates[None, :n])[0, :, :2, 3].mean(axis=0)
        askew = chances.place.uniform(-1, 1, 3) * (TILTED, TILTED, np.pi)
        truth |= {f"target.{part}": float(value) for part, value in zip(SIX, (*middle, height, *askew), strict=True)}
        height = 0.0

    def measure(values: Mapping[str, Array], inside: Sequence[CandidateEffect]) -> _Measure:
        return lambda _, standing: stripe_points(standing, inside, values, view=view, at=at, level=height)

    return _World(truth, candidates, measure)


def _tracker(blank: Dataset, points: int, chances: _Chances) -> _World:
    rng = chances.build
    turn = rng.uniform(-np.pi, np.pi)
    tilt = rng.uniform(-TILTED, TILTED, 2)
    base = (*(np.array(TRACKER_M) + rng.uniform(-0.5, 0.5, 3)), *tilt, turn)
    truth = {f"base.{part}": float(value) for part, value in zip(SIX, base, strict=True)}
    names = tuple(map(str, range(points)))
    for i, name in enumerate(names):
        angle, radius = 2 * np.pi * i / points + rng.uniform(-0.3, 0.3), rng.uniform(*REFLECTORS_M)
        place = (radius * np.cos(angle), radius * np.sin(angle), rng.uniform(0.02, 0.08))
        truth |= {f"tool.{name}.{part}": float(value) for part, value in zip("xyz", place, strict=True)}
    candidates = random_configurations(_arm(blank), len(blank.poses), chances.place)
    return _World(
        truth,
        candidates,
        lambda values, inside: lambda _, standing: tracker_points(standing, inside, values, names=names),
    )


def _sockets(blank: Dataset, points: int, chances: _Chances) -> _World:
    robot = _arm(blank)
    ball = np.array(BALL_M) + HAND_MADE_M * chances.build.uniform(-1, 1, 3)
    sockets = within_reach(robot, ball, points, chances.place)
    candidates, goals = reaching(robot, ball, sockets, wanted=len(blank.poses), rng=chances.place)
    truth = {f"tool.ball.{part}": float(value) for part, value in zip("xyz", ball, strict=True)}
    for i, socket in enumerate(sockets):
        truth |= {f"socket.{i}.{part}": float(value) for part, value in zip("xyz", socket, strict=True)}
    known = tuple((str(i), str(i + 1), float(np.linalg.norm(sockets[i + 1] - sockets[i]))) for i in range(points - 1))

    def measure(values: Mapping[str, Array], inside: Sequence[CandidateEffect]) -> _Measure:
        return lambda chosen, standing: seated(
            replace(standing, distances_m=known), inside, values, sockets=sockets, of=goals[chosen].tolist()
        )

    return _World(truth, candidates, measure)


def _arm(dataset: Dataset) -> Robot:
    assert dataset.robot is not None  # a simulated cell has one
    return dataset.robot


def _settled(
    moving: Dataset, candidates: Array, measure: _Measure, pause_s: float, rng: np.random.Generator
) -> Dataset:
    """Stand in the first candidates, in any order, and replace those that do not do until all do."""
    n = len(moving.poses)
    chosen, spare = rng.permutation(n), n
    while True:
        q = candidates[chosen]
        dataset, good = measure(chosen, replace(moving, poses=replace(moving.poses, q=q, time_s=_times(q, pause_s))))
        bad = np.flatnonzero(~good)
        if not len(bad):
            return dataset
        if spare + len(bad) > len(candidates):
            raise EffectError(
                f"{_arm(moving).name}: {n} poses are needed, but of {spare} planned ones only {n - len(bad)} still see"
                " the target or reach the socket with the effects in place. Take smaller effects, or fewer poses."
            )
        chosen[bad] = np.arange(spare, spare + len(bad))
        spare += len(bad)


def _times(q: Array, pause_s: float) -> Array:
    travel = np.abs(np.diff(q, axis=0)).max(axis=1) / TRAVEL
    times: Array = np.concatenate([[0.0], np.cumsum(pause_s + travel)]).round(3)
    return times


def _noisy(exact: Dataset, noise: Noise, repeats: int, chances: _Chances) -> Dataset:
    (robot, q), poses, points = exact.arm, exact.poses, exact.points
    if noise.joint_rad is not None:
        shaken = noise.joint_rad * chances.joint_noise.normal(size=q.shape)
        poses = replace(poses, q=q + np.where(robot.prismatic, 0.0, shaken))
    rng = chances.point_noise
    if points.pixel is not None and points.xyz is not None and noise.target_m is not None:
        points = replace(points, xyz=points.xyz + noise.target_m * rng.normal(size=points.xyz.shape))
    if repeats > 1:
        shots = np.tile(np.arange(repeats), len(points))
        points = replace(points.take(np.repeat(np.arange(len(points)), repeats)), repeat=shots)
    if points.pixel is not None and noise.pixel_px is not None:
        points = replace(points, pixel=points.pixel + noise.pixel_px * rng.normal(size=points.pixel.shape))
    if points.pixel is None and points.xyz is not None and noise.point_m is not None:
        points = replace(points, xyz=points.xyz + noise.point_m * rng.normal(size=points.xyz.shape))
    return replace(exact, poses=poses, points=points)
