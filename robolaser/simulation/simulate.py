"""Simulated data sets, of any robot and with any departures from its nominal model."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field, replace
from typing import final, get_args

import numpy as np

from robolaser.arrays import Array, Ints
from robolaser.data.dataset import Dataset, Poses
from robolaser.data.importers.robots import find_robot
from robolaser.data.joining import join_sessions
from robolaser.data.sensor_format import Mount
from robolaser.data.sessions import Sessions
from robolaser.data.stated_noise import Noise
from robolaser.errors import EffectError, UsageError, check_seed
from robolaser.model.effects.outliers import NAME as OUTLIERS
from robolaser.model.effects.outliers import WHERE as OF_OUTLIERS
from robolaser.parameters import Values, as_batch
from robolaser.robot.kinematics import Robot
from robolaser.robot.postures import limits
from robolaser.simulation.corners import seen_beside
from robolaser.simulation.effect_specs import numbers_of
from robolaser.simulation.sensors import simulated_sensor
from robolaser.simulation.sensors.simulated_sensor import SimulatedSensor, impossible
from robolaser.simulation.setup import CellOptions, Effects, RandomStreams, SensorSetup

TRAVEL = 0.3  # fastest joint's mean speed between poses [rad/s or m/s]
PAUSE_S = 30.0  # time spent at each pose
EXPOSURE_SPEED = 0.1  # joints' speed at the exposure, for an effect of the timing [rad/s or m/s]
WORDS = {"stripe_axis": ("u", "v"), "mount": get_args(Mount)}  # what options may be
MOST_GROSS = 0.5  # of the rows: beyond, gross errors are the rule


@final
@dataclass(frozen=True)
class Simulated:
    """A simulated data set and its truth.

    Examples:
        >>> from robolaser.simulation import paper
        >>> simulated = paper(robolaser.find_robot("scorbot_er7"), effects={"laser_roll": 0.03})
        >>> simulated.truth["laser_roll.laser.angle"]
        0.03
    """

    dataset: Dataset  # as measured
    truth: Mapping[str, float]  # every parameter of the sensor, and the numbers of the effects, by name
    effects: Effects = ()  # its effects
    gross: Ints = field(default_factory=lambda: np.empty(0, dtype=np.int64))  # rows with gross errors


def simulate(
    robot: Robot | str,
    *,
    kind: str = "stripe",
    poses: int = 40,
    points: int | None = None,
    noise: Noise | None = None,
    effects: Mapping[str, float] | None = None,
    options: CellOptions | None = None,
    seed: int = 0,
) -> Simulated:
    """Simulate a data set, with a scanner built to the tolerances of `nominal.BUILT`.

    The arm visits random configurations in which it can measure. Without noise, the model with the true parameters and
    effects has no residuals.

    Args:
        robot: The nominal arm, or what `find_robot` takes.
        kind: "stripe", "camera", "point" (a tracker), "pose" (a 6-D tracker), "socket", "profile", or
            "stripe+camera": a scanner whose images show a board.
        poses: Number of poses, in each session.
        points: Of a stripe in each pose (12 when absent); corners of a camera's board (35); reflectors on the flange,
            or sockets in the cell (3); bodies on the flange (1); balls of a profile sensor (3), 24 points on one of
            them in each pose.
        noise: Added noise; default: none. Repeats of a stripe's point share its target error.
        effects: Sizes by NAME[:WHERE[.NUMBER]]: without NUMBER the principal one, without WHERE at every location.
            `outliers` is the share of rows with gross errors.
        options: Other differences from the usual cell.
        seed: The same seed gives the same data set.

    Raises:
        RobotError: The arm sees the target or reaches a socket in too few configurations.
        EffectError: The same with the effects, or these are impossible.
        UsageError: A number or word is invalid.

    Examples:
        >>> from robolaser.simulation import simulate
        >>> effects = {"joint_offset:elbow_joint": 0.002}
        >>> made = simulate(robolaser.find_robot("ur5e"), kind="socket", poses=20, effects=effects, seed=1)
        >>> made.dataset
        <Dataset simulated-ur5e: ball in fixed sockets, robot ur5e, 20 points in 20 poses>
    """
    check_seed(seed)
    options = options or CellOptions()
    with_corners = kind == "stripe+camera"
    sensor_type = simulated_sensor("stripe" if with_corners else kind)
    points = sensor_type.default_points if points is None else points
    sensor_type.check_counts(poses=poses, points=points, repeats=options.repeats)
    arm = find_robot(robot) if isinstance(robot, str) else robot
    setup = SensorSetup(points, options, frozenset(name.partition(":")[0] for name in effects or ()))
    cell = _Cell(arm, sensor_type, setup, poses, noise or Noise(), effects or {}, with_corners=with_corners)
    _check_noise(cell.noise)
    for what, known in WORDS.items():
        if (word := getattr(options, what)) not in known:
            raise impossible(what, word, " or ".join(known))
    if options.sessions < 1:
        raise impossible("number of sessions", options.sessions, "1 or more")
    first = cell.session(seed, {})
    if options.sessions == 1:
        return first
    if once := next((str(one) for one in first.effects if one.effect.begins), ""):
        raise UsageError(f"{once} happens at one moment, and not in each session: simulate it in one session.")
    names = Sessions(tuple(f"session-{number + 1}" for number in range(options.sessions)))
    shared = {parameter: value for parameter, value in first.truth.items() if not names.is_own(parameter)}
    later = np.random.SeedSequence(seed).generate_state(options.sessions - 1, np.uint64).tolist()
    return _joined(names, [first, *(cell.session(int(own), shared) for own in later)])


@final
@dataclass(frozen=True)
class _Cell:
    """The request for a cell, the same in all its sessions."""

    robot: Robot
    sensor_type: type[SimulatedSensor]
    setup: SensorSetup
    poses: int
    noise: Noise
    effects: Mapping[str, float]
    with_corners: bool

    def session(self, seed: int, shared: Mapping[str, float]) -> Simulated:
        """A campaign, whose sensor is shared with the first one."""
        random, options = RandomStreams.of(seed), self.setup.options
        blank = self._described(random)
        sensor = self.sensor_type.build(blank, replace(self.setup, known=shared), random)
        sizes = dict(self.effects)
        share = _share_of_outliers(sizes)
        effects, numbers = numbers_of(sizes, blank)
        rests = options.speed is None and not any(effect.where == "timing" for effect in effects)
        if rests or options.speed == 0:
            blank = replace(blank, poses=replace(blank.poses, qd=None))
        truth = {**sensor.truth, **shared, **numbers}
        exact = _measure(blank, sensor, truth, effects, random.order)
        noisy = _add_noise(exact, sensor, self.noise, options.repeats, random)
        rows, sign = _gross_rows(len(noisy.points), share, random.gross)
        spoilt = sensor.add_gross_errors(noisy, rows, sign, random.gross) if len(rows) else noisy
        if self.with_corners:
            spoilt = seen_beside(exact, truth, effects, spoilt, self.noise, random.point_noise)
        return Simulated(spoilt, truth, effects, rows)

    def _described(self, random: RandomStreams) -> Dataset:
        """The data set before any measurement: its poses are in the middle of the joint limits."""
        robot, options = self.robot, self.setup.options
        speed = EXPOSURE_SPEED if options.speed is None else options.speed
        way = random.speed.uniform(-1.0, 1.0, (self.poses, len(robot.joints)))
        q = np.tile(np.mean(limits(robot), axis=0), (self.poses, 1))
        blank = Dataset(
            name=options.name or f"simulated-{robot.name}",
            source="simulated by robolaser",
            robot=robot,
            kind=self.sensor_type.kind,
            poses=Poses(tuple(map(str, range(self.poses))), time_s=_times(q), q=q, qd=speed * way),
            noise=options.stated or self.noise,
        )
        return self.sensor_type.describe(blank, self.setup)


def _joined(sessions: Sessions, made: Sequence[Simulated]) -> Simulated:
    """Campaigns as one; known distances are omitted, since sockets of one name differ between them."""
    datasets = [replace(one.dataset, distances_m=()) for one in made]
    rows = np.cumsum([0, *(len(one.points) for one in datasets)])
    return Simulated(
        join_sessions(dict(zip(sessions.names, datasets, strict=True)), name=datasets[0].name),
        {
            sessions.named(parameter, session): value
            for session, one in zip(sessions.names, made, strict=True)
            for parameter, value in one.truth.items()
        },
        made[0].effects,
        np.concatenate([one.gross + before for one, before in zip(made, rows[:-1], strict=True)]),
    )


def paper(robot: Robot, *, effects: Mapping[str, float] | None = None, seed: int = 0) -> Simulated:
    """The experiment of Lee et al. 2004: 5 points in each of 5 poses, a target known to 0.3 mm, no stated noise.

    Examples:
        >>> from robolaser.simulation import paper
        >>> len(paper(robolaser.find_robot("scorbot_er7"), seed=1).dataset.points)
        25
    """
    noise, options = Noise(target_m=3e-4), CellOptions(stated=Noise(), name="paper")
    return simulate(robot, poses=5, points=5, noise=noise, effects=effects, options=options, seed=seed)


def _check_noise(noise: Noise) -> None:
    for what, sigma in vars(noise).items():
        if sigma is not None and not 0 < sigma < np.inf:
            raise impossible(f"noise {what} of", sigma, "a positive number, or nothing for none")


def _measure(
    blank: Dataset, sensor: SimulatedSensor, truth: Mapping[str, float], effects: Effects, rng: np.random.Generator
) -> Dataset:
    """Measure in the first candidates, in random order, and replace those in which the sensor cannot until it can."""
    values: Values = as_batch(truth)
    (robot, _), n, candidates = blank.arm, len(blank.poses), sensor.candidates
    chosen, spare = rng.permutation(n), n
    while True:
        q = candidates[chosen]
        there = replace(blank, poses=replace(blank.poses, q=q, time_s=_times(q)))
        dataset, good = sensor.measure(there, chosen, values, effects)
        bad = np.flatnonzero(~good)
        if not len(bad):
            return dataset
        if spare + len(bad) > len(candidates):
            raise EffectError(
                f"{robot.name}: {n} poses are needed, but of {spare} planned ones only {n - len(bad)} still see"
                " the target or reach the socket with the effects in place. Choose smaller effects, or fewer poses."
            )
        chosen[bad] = np.arange(spare, spare + len(bad))
        spare += len(bad)


def _times(q: Array) -> Array:
    travel = np.abs(np.diff(q, axis=0)).max(axis=1) / TRAVEL
    return np.concatenate([[0.0], np.cumsum(PAUSE_S + travel)]).round(3)


def _share_of_outliers(sizes: dict[str, float]) -> float:
    """Remove the share of gross errors from the requested effects; 0 where there is none."""
    share = sizes.pop(f"{OUTLIERS}:{OF_OUTLIERS}", 0.0) or sizes.pop(OUTLIERS, 0.0)
    if not 0 <= share <= MOST_GROSS:
        raise impossible(f"share of {OUTLIERS}", share, f"a number from 0 to {MOST_GROSS:g}")
    return share


def _gross_rows(count: int, share: float, rng: np.random.Generator) -> tuple[Ints, Array]:
    """A share of so many rows, one at least, and the sign of each error (±1), (g,) and (g,)."""
    if not share:
        return np.empty(0, dtype=np.int64), np.empty(0)
    rows = np.sort(rng.choice(count, size=max(1, round(share * count)), replace=False))
    return rows, rng.choice([-1.0, 1.0], size=len(rows))


def _add_noise(exact: Dataset, sensor: SimulatedSensor, noise: Noise, repeats: int, random: RandomStreams) -> Dataset:
    robot, q = exact.arm
    if noise.joint_rad is not None:
        q = q + np.where(robot.prismatic, 0.0, noise.joint_rad * random.joint_noise.normal(size=q.shape))
    if noise.joint_step_rad is not None:
        q = np.where(robot.prismatic, q, noise.joint_step_rad * np.round(q / noise.joint_step_rad))
    points = sensor.add_shared_noise(exact.points, noise, random.point_noise)
    if repeats > 1:
        shots = np.tile(np.arange(repeats), len(points))
        points = replace(points.take(np.repeat(np.arange(len(points)), repeats)), repeat=shots)
    off = (noise.distance_m or 0.0) * random.distance_noise.normal(size=len(exact.distances_m))
    distances = tuple((*pair, d + e) for (*pair, d), e in zip(exact.distances_m, off.tolist(), strict=True))
    points = sensor.add_noise(points, noise, random.point_noise)
    return replace(exact, poses=replace(exact.poses, q=q), points=points, distances_m=distances)
