"""A simulated laser profile sensor and its balls: one of them on the arm, the others in the cell."""

from dataclasses import dataclass, replace
from typing import ClassVar, Self, final

import numpy as np

from robolaser.arrays import Array, Bools, Ints
from robolaser.data.dataset import Dataset, Points
from robolaser.geometry.rigid_motion import apply, from_angles, from_quaternion, inverse, pose
from robolaser.model.blocks.cell_frames import in_cell
from robolaser.model.forward_model import Model
from robolaser.model.sensors.in_cell import Mounting
from robolaser.model.sensors.placements import motion, named_parts, numbers_of_motion, vector
from robolaser.model.sensors.profile import ARC, MOST_CUT, ROWS
from robolaser.parameters import Values
from robolaser.robot.inverse_kinematics import reaching, within_reach
from robolaser.robot.postures import limits
from robolaser.simulation.nominal import facing_outward
from robolaser.simulation.sensors.simulated_sensor import SimulatedSensor, nominal_points
from robolaser.simulation.setup import Effects, RandomStreams, SensorSetup

RADIUS_M = 0.0127
STANDOFF_M = 0.15  # from the sensor to the middle of its range
RANGE_M = (0.03, 0.03)  # half its range, along x and z: a sensor of the 60 mm class
BRACKET_M = (0.03, -0.02, 0.05)  # of the sensor on the flange, z outward
TOLERANCE = 0.03  # its largest turn from nominal [rad]
BALLS_M = (0.06, 0.10)  # of balls on the flange, from its axis, least and most
SHAKE, TRIES = 0.015, 16  # difference of postures that aim at one ball [rad or m], and how many are tried
GROSS_M = (1e-3, 5e-3)  # a reflection is mistaken for the ball


@final
@dataclass(frozen=True)
class SimulatedProfile(SimulatedSensor):
    """A profile sensor that sees one ball in each pose."""

    kind: ClassVar[str] = "profile"
    own_noise: ClassVar[tuple[str, str]] = ("profile", "point_m")

    ball_of: Ints  # the ball of each candidate, (≥ n,)
    at: Array  # positions of each pose's points along the arc, -1 to 1, (≥ n, k)
    is_static: bool  # whether the sensor is in the cell

    @classmethod
    def describe(cls, dataset: Dataset, setup: SensorSetup) -> Dataset:
        """With the mount of the sensor, and the radius of each ball."""
        radii = {str(ball): RADIUS_M for ball in range(setup.points)}
        return replace(dataset, options=Mounting(setup.options.mount), radius_m=radii)

    @classmethod
    def build(cls, dataset: Dataset, setup: SensorSetup, random: RandomStreams) -> Self:
        """A sensor on the flange that looks away from the arm and balls in the cell, or the other way round."""
        robot, n, rng = dataset.arm[0], len(dataset.poses), random.build
        outward = from_quaternion(np.array(facing_outward(robot)))
        tilt = from_angles(*rng.uniform(-TOLERANCE, TOLERANCE, 3))
        is_static = setup.options.mount == "base"
        if is_static:
            turn = rng.uniform(-np.pi, np.pi, setup.points)
            around = np.stack([np.cos(turn), np.sin(turn), np.ones_like(turn)], axis=-1)
            balls = around * rng.uniform(*BALLS_M, (setup.points, 1)) @ outward.T
            T, ahead = setup.hand_eye, np.array([[0.0, 0.0, STANDOFF_M]])
            aim = within_reach(robot, balls[0], 1, random.place) if T is None else apply(T, ahead)
            of_ball = [reaching(robot, ball, aim, wanted=-(-n // len(balls)), rng=random.place)[0] for ball in balls]
            least = min(map(len, of_ball))
            q = np.stack([found[:least] for found in of_ball], axis=1).reshape(-1, len(robot.joints))
            goals = np.tile(np.arange(len(balls)), least)
            R = from_angles(*rng.uniform(-1.0, 1.0, 3)) @ tilt
            T = pose(R, aim[0] - STANDOFF_M * R[:, 2]) if T is None else T
        else:
            T = pose(outward @ tilt, outward @ np.array(BRACKET_M)) if setup.hand_eye is None else setup.hand_eye
            aim = T[:3, 3] + STANDOFF_M * T[:3, 2]
            balls = within_reach(robot, aim, setup.points, random.place)
            q, goals = reaching(robot, aim, balls, wanted=n, rng=random.place)
        truth = numbers_of_motion(T, "hand_eye")
        for number, ball in enumerate(balls):
            truth |= named_parts(f"ball.{number}", ball)
        lower, upper = limits(robot)
        kept_q, kept_ball = [np.empty((0, q.shape[1]))], [np.empty(0, dtype=np.int64)]
        for _ in range(TRIES):
            shaken = np.clip(q + SHAKE * random.place.normal(size=q.shape), lower, upper)
            T_base_flange = robot.forward(shaken)
            T_base_sensor = T if is_static else T_base_flange @ T
            ball = apply(T_base_flange, balls[goals]) if is_static else balls[goals]
            good = _is_seen(apply(inverse(T_base_sensor), ball))
            kept_q.append(shaken[good])
            kept_ball.append(goals[good])
        candidates, ball_of = np.concatenate(kept_q), np.concatenate(kept_ball)
        return cls(truth, candidates, ball_of, random.along.uniform(-1.0, 1.0, (len(candidates), ROWS)), is_static)

    def measure(self, dataset: Dataset, chosen: Ints, values: Values, effects: Effects) -> tuple[Dataset, Bools]:
        """The arc in which the sensor's plane cuts the ball that the pose aims at."""
        n, number = len(dataset.poses), self.ball_of[chosen]
        rows = np.repeat(np.arange(n), ROWS)
        names = tuple(str(ball) for ball in number.repeat(ROWS).tolist())
        points = Points(rows, names, columns={"profile": np.zeros((len(rows), 2))})
        model = Model(replace(dataset, points=points), effects)
        perturb = model.perturb(values)
        T_base_flange = model.flange(values, perturb)[0]
        mount = in_cell(model.blocks, values, perturb).mount
        T_base_sensor = motion(values, "hand_eye")[0] if mount is None else T_base_flange @ mount[0]
        ball = np.stack([vector(values, f"ball.{one}")[0] for one in number])
        there = apply(inverse(T_base_sensor), apply(T_base_flange, ball) if self.is_static else ball)
        good = _is_seen(there)
        radius = np.sqrt(np.maximum(RADIUS_M**2 - there[:, 1] ** 2, 0.0))[:, None]
        angle = ARC * self.at[chosen]
        lit = np.stack(
            [there[:, :1] + radius * np.sin(angle), np.zeros_like(angle), there[:, 2:] - radius * np.cos(angle)],
            axis=-1,
        ).reshape(-1, 3)
        seen = nominal_points(lit, perturb)[:, ::2]
        return replace(dataset, points=replace(points, columns={"profile": seen})), good

    @classmethod
    def add_gross_errors(cls, dataset: Dataset, rows: Ints, sign: Array, rng: np.random.Generator) -> Dataset:
        """Points nearer or farther than the ball."""
        profile = dataset.points["profile"].copy()
        profile[rows, 1] += sign * rng.uniform(*GROSS_M, len(rows))
        return replace(dataset, points=replace(dataset.points, columns={"profile": profile}))


def _is_seen(ball: Array) -> Bools:
    """Whether balls in the sensor's frame (n, 3) are in its range, and cut well."""
    across, deep = RANGE_M
    near = (np.abs(ball[:, 0]) < across - RADIUS_M) & (np.abs(ball[:, 2] - STANDOFF_M) < deep - RADIUS_M)
    return np.asarray(near & (np.abs(ball[:, 1]) < MOST_CUT * RADIUS_M))
