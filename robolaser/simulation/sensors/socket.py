"""A simulated ball on the flange that the arm seats in fixed sockets."""

from dataclasses import dataclass, replace
from itertools import pairwise
from typing import ClassVar, Self, final

import numpy as np

from robolaser.arrays import Array, Bools, Ints
from robolaser.data.dataset import Dataset, Points
from robolaser.geometry.rigid_motion import apply
from robolaser.model.forward_model import Model
from robolaser.model.sensors.placements import named_parts, vector
from robolaser.parameters import Values
from robolaser.robot.inverse_kinematics import REACHED_M, reaching, touching, within_reach
from robolaser.simulation.sensors.simulated_sensor import SimulatedSensor, impossible, moved_within
from robolaser.simulation.setup import Effects, RandomStreams, SensorSetup

BALL_M = (0.03, -0.02, 0.12)  # of the ball in the flange frame
TOLERANCE_M = 0.002  # largest distance of the ball from nominal along each axis
ROUNDS = 10  # of aiming
GROSS_RAD = (0.01, 0.05)  # of one joint in a pose whose ball is not seated [rad or m]


@final
@dataclass(frozen=True)
class SimulatedSockets(SimulatedSensor):
    """A ball and its sockets."""

    kind: ClassVar[str] = "socket"

    sockets: Array  # in the base frame, (s, 3) [m]
    socket_of: Ints  # the socket of each candidate, (≥ n,)

    @classmethod
    def check_counts(cls, *, poses: int, points: int, repeats: int) -> None:
        """A pose is one seat: no repeats, and a pose for each socket."""
        super().check_counts(poses=poses, points=points, repeats=repeats)
        if repeats > 1:
            raise impossible("number of repeats", repeats, "1: each seating of the ball is a pose of its own")
        if poses < points:
            raise impossible("number of poses", poses, f"at least one for each of {points} sockets")

    @classmethod
    def build(cls, dataset: Dataset, setup: SensorSetup, random: RandomStreams) -> Self:
        """A ball and sockets that it reaches from many sides."""
        robot, _ = dataset.arm
        ball = np.array(BALL_M) + TOLERANCE_M * random.build.uniform(-1, 1, 3)
        sockets = within_reach(robot, ball, setup.points, random.place)
        candidates, goals = reaching(robot, ball, sockets, wanted=len(dataset.poses), rng=random.place)
        truth = named_parts("tool.ball", ball)
        for i, socket in enumerate(sockets):
            truth |= named_parts(f"socket.{i}", socket)
        return cls(truth, candidates, sockets, goals)

    def measure(self, dataset: Dataset, chosen: Ints, values: Values, effects: Effects) -> tuple[Dataset, Bools]:
        """Configurations with the ball truly in its socket; distances of neighbouring sockets are known."""
        of = self.socket_of[chosen].tolist()
        robot, q = dataset.arm
        distances_m = tuple(
            (str(i), str(i + 1), float(np.linalg.norm(after - before)))
            for i, (before, after) in enumerate(pairwise(self.sockets))
        )
        dataset = replace(dataset, points=Points(np.arange(len(q)), tuple(map(str, of))), distances_m=distances_m)

        def at(q: Array) -> Dataset:
            return replace(dataset, poses=replace(dataset.poses, q=q))

        tool, sockets = vector(values, "tool.ball")[0], self.sockets[of]
        aim = sockets
        for _ in range(ROUNDS):  # the nominal arm aims beside the socket by what its errors move the ball
            T = Model(at(q), effects).flange(values)[0]
            short = sockets - apply(T, tool)
            good = np.asarray((np.abs(short) < REACHED_M).all(axis=1))
            if good.all():
                break
            aim = aim + short
            q, _ = touching(robot, tool, aim, q)
        return at(q), good

    @classmethod
    def add_gross_errors(cls, dataset: Dataset, rows: Ints, sign: Array, rng: np.random.Generator) -> Dataset:
        """An error of one joint's reading each."""
        (robot, read), pose = dataset.arm, dataset.points.pose[rows]
        q = read.copy()
        joint = np.array(robot.chain)[rng.integers(len(robot.chain), size=len(rows))]
        by = sign * rng.uniform(*GROSS_RAD, len(rows))
        q[pose, joint] = moved_within(q[pose, joint], by, robot.lower[joint], robot.upper[joint])
        return replace(dataset, poses=replace(dataset.poses, q=q))
